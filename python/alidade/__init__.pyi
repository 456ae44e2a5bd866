# SPDX-License-Identifier: MIT
from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Literal

from numpy import bool_, float64, int64
from numpy.typing import ArrayLike, NDArray

from ._answers import (
    Change as Change,
    Comparison as Comparison,
    HitLists as HitLists,
    Hits as Hits,
    Map as Map,
    NeighbourLists as NeighbourLists,
    Neighbours as Neighbours,
    PathHits as PathHits,
    PointLists as PointLists,
    Points as Points,
    Raster as Raster,
    RenderedImage as RenderedImage,
    Rendering as Rendering,
    Rows as Rows,
)

from . import jobs as jobs, visibility as visibility

__version__: str
Progress = Callable[[int, int], Any]
File = str | PathLike[str]
Measure = Literal["entry", "t", "distance"]

class Error(ValueError): ...

class Cloud:
    def __init__(self, xyz: ArrayLike, *, crs: str | None = None, scale: float | None = None,
                 **attributes: ArrayLike) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> NDArray[Any]: ...
    def __contains__(self, name: str) -> bool: ...
    def keys(self) -> list[str]: ...
    @property
    def xyz(self) -> NDArray[float64]: ...
    @property
    def bounds(self) -> NDArray[float64]: ...
    @property
    def crs(self) -> str | None: ...
    @property
    def scale(self) -> tuple[float, float, float]: ...
    def index(self, *, organisation: Literal["adaptive", "layered"] = "adaptive", surfaces: bool = False,
              workers: int = -1, progress: Progress | None = None) -> Index: ...
    def write(self, file: File, *, overwrite: bool = False, progress: Progress | None = None) -> None: ...

class Index(Cloud):
    def save(self, file: File, *, overwrite: bool = False, progress: Progress | None = None) -> None: ...
    def closest(self, rays: ArrayLike | None = None, *, origins: ArrayLike | None = None,
                directions: ArrayLike | None = None, radius: float | None = None, measure: Measure | None = None,
                t_min: ArrayLike = 0.0, t_max: ArrayLike | None = None, where: NDArray[bool_] | None = None,
                classes: Sequence[int] | None = None, max_level: int | None = None, workers: int = -1) -> Hits: ...
    def occluded(self, rays: ArrayLike | None = None, *, origins: ArrayLike | None = None,
                 directions: ArrayLike | None = None, radius: float | None = None, measure: Measure = "distance",
                 t_min: ArrayLike = 0.0, t_max: ArrayLike | None = None, where: NDArray[bool_] | None = None,
                 classes: Sequence[int] | None = None, max_level: int | None = None,
                 workers: int = -1) -> NDArray[bool_]: ...
    def count(self, rays: ArrayLike | None = None, *, origins: ArrayLike | None = None,
              directions: ArrayLike | None = None, radius: float | None = None, measure: Measure = "distance",
              t_min: ArrayLike = 0.0, t_max: ArrayLike | None = None, where: NDArray[bool_] | None = None,
              classes: Sequence[int] | None = None, max_level: int | None = None, workers: int = -1,
              k: int = 0) -> NDArray[int64]: ...
    def nearest(self, rays: ArrayLike | None = None, *, origins: ArrayLike | None = None,
                directions: ArrayLike | None = None, radius: float | None = None, measure: Measure = "distance",
                t_min: ArrayLike = 0.0, t_max: ArrayLike | None = None, where: NDArray[bool_] | None = None,
                classes: Sequence[int] | None = None, max_level: int | None = None, workers: int = -1,
                k: int = 1) -> Hits: ...
    def within(self, rays: ArrayLike | None = None, *, origins: ArrayLike | None = None,
               directions: ArrayLike | None = None, radius: float | None = None, measure: Measure | None = None,
               t_min: ArrayLike = 0.0, t_max: ArrayLike | None = None, where: NDArray[bool_] | None = None,
               classes: Sequence[int] | None = None, max_level: int | None = None, workers: int = -1,
               k: int = 0) -> HitLists: ...
    def nearest_points(self, xyz: ArrayLike, k: int = 1, *, radius: float | None = None,
                       where: NDArray[bool_] | None = None, classes: Sequence[int] | None = None,
                       max_level: int | None = None, workers: int = -1) -> Neighbours: ...
    def points_within(self, xyz: ArrayLike, radius: float, *, where: NDArray[bool_] | None = None,
                      classes: Sequence[int] | None = None, max_level: int | None = None,
                      workers: int = -1) -> NeighbourLists: ...
    def in_box(self, boxes: ArrayLike, *, where: NDArray[bool_] | None = None, classes: Sequence[int] | None = None,
               max_level: int | None = None, workers: int = -1) -> PointLists: ...
    def in_cone(self, rays: ArrayLike, angle: float, *, radius: float = 0.0, t_max: ArrayLike | None = None,
                where: NDArray[bool_] | None = None, classes: Sequence[int] | None = None,
                max_level: int | None = None, workers: int = -1) -> HitLists: ...
    def along(self, path: ArrayLike, radius: float, *, where: NDArray[bool_] | None = None,
              classes: Sequence[int] | None = None, max_level: int | None = None, workers: int = -1) -> PathHits: ...

def open(files: File | Sequence[File], *, partial: bool = False, classes: str | Sequence[int] | None = None,
         ignore_classes: str | Sequence[int] | None = None, where: str | None = None,
         crop: File | Sequence[float] | None = None, crop_crs: str | None = None,
         columns: str | Sequence[str] | None = None, crs: str | None = None, reproject: str | None = None,
         vertical_unit: Literal["m", "ft", "us-ft"] | None = None, cache: File | None = None,
         allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, yes: bool = False,
         workers: int = -1, progress: Progress | None = None) -> Cloud: ...
def render(index: Index, *, camera: dict[str, Any] | File | None = None, scene: dict[str, Any] | str | None = None,
           size: tuple[int, int] = (1200, 800), samples: int | None = None, layers: Sequence[str] = ...,
           exposure: float | None = None, seed: int | None = None, workers: int = -1,
           progress: Progress | None = None) -> dict[str, NDArray[Any]]: ...
def visible(index: Index, observers: ArrayLike, *, height: float | None = None, max_distance: float | None = None,
            transparency: int = 1, workers: int = -1, progress: Progress | None = None) -> NDArray[bool_]: ...
def viewshed(index: Index, observers: ArrayLike, resolution: float, *,
             mode: Literal["visible", "count", "height", "fraction"] = "visible",
             extent: tuple[float, float, float, float] | None = None, height: float | None = None,
             target_height: float = 0.0, max_distance: float | None = None, transparency: int = 1,
             workers: int = -1, progress: Progress | None = None) -> Raster: ...
def compare(reference: ArrayLike, test: ArrayLike, *, workers: int = -1) -> Comparison: ...
