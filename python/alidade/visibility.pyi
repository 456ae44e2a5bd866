# SPDX-License-Identifier: MIT
from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike

from ._answers import Map

_File = str | PathLike[str]
_Pair = str | tuple[float, float]

def raster(files: _File | Sequence[_File], *, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
           note: Callable[[str], Any] | None = None, classes: str | Sequence[int] | None = None, where: str | None = None,
           crop: _File | Sequence[float] | None = None, crop_crs: str | None = None,
           columns: str | Sequence[str] | None = None, crs: str | None = None, reproject: str | None = None,
           vertical_unit: Literal["m", "ft", "us-ft"] | None = None, cache: _File | None = None,
           allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, partial: bool = False,
           output: _File | None = None, overwrite: bool = False,
           preview: _File | None = None, resolution: float | None = None,
           extent: str | tuple[float, float, float, float] | None = None,
           ground: Literal["auto", "class", "lowest", "highest"] | None = None, ground_cell: float | None = None,
           ground_reach: float | None = None,
           mode: Literal["visible", "count", "height", "fraction", "size", "solid-angle"] | None = None,
           visible_value: int | None = None, invisible_value: int | None = None, out_of_range_value: int | None = None,
           highest: float | None = None, places: int | None = None, observer: ArrayLike | None = None,
           observers: _File | None = None, observers_crs: str | None = None, anywhere: bool = False,
           observer_grid: float | None = None, observer_height: float | None = None, max_distance: float | None = None,
           horizontal_fov: _Pair | None = None, direction_range: _Pair | None = None, vertical_fov: _Pair | None = None,
           object: ArrayLike | None = None, objects: _File | None = None, objects_crs: str | None = None,
           object_spacing: float | None = None, object_width: float | None = None, target_height: float | None = None,
           like: Literal["gdal", "grass"] | None = None, curvature: float | None = None,
           refraction_coeff: float | None = None, occluder: Literal["auto", "disc", "sphere"] | None = None,
           radius: float | None = None, radius_max: float | None = None, transparency: int | None = None,
           mesh: _File | Sequence[_File] | None = None, terrain: _File | None = None,
           ignore_classes: str | Sequence[int] | None = None, checkpoint: _File | None = None,
           checkpoint_interval: float | None = None, resume: bool = False, memory: int | str | None = None) -> Map: ...
