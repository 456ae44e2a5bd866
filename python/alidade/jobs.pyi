# SPDX-License-Identifier: MIT
from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike

from . import Cloud
from ._answers import Change, Rows

_File = str | PathLike[str]
_Files = _File | Sequence[_File]
_List = int | str | Sequence[int] | Sequence[str]

# Made by tests/python/stubs.py from here
def catalog(files: _Files, *, cache: _File | None = None, allow_host: str | Sequence[str] | None = None,
            cache_size: int | str | None = None, output: _File | None = None, measure: bool = False,
            overwrite: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
            note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def change(before: _File, after: _File, *, classes: _List | None = None, where: str | None = None,
           crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
           crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
           cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
           output: _File | None = None, origin_before: str | ArrayLike | None = None, origins_before: _File | None = None,
           origin_after: str | ArrayLike | None = None, origins_after: _File | None = None, no_sight: bool = False,
           max_range: float | None = None, registration_error: float | None = None, normal_radius: float | None = None,
           cylinder_radius: float | None = None, max_distance: float | None = None, ignore_classes: _List | None = None,
           overwrite: bool = False, memory: int | str | None = None, partial: bool = False, workers: int = -1,
           progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> Change: ...
def compare(reference: _File | None = None, test: _File | None = None, *, pairs: _File | None = None,
            crop: str | ArrayLike | None = None, resize: Literal["none", "reference"] | None = None,
            mask: _File | None = None, only: str | ArrayLike | None = None, ignore: str | ArrayLike | None = None,
            opaque: bool = False, valid_depth: bool = False, ignore_sky: bool = False,
            match: Literal["exposure", "affine"] | None = None, align: bool = False, largest_shift: float | None = None,
            pixels_per_degree: int | None = None, tone_mapper: Literal["aces", "hable", "reinhard"] | None = None,
            start_exposure: float | None = None, stop_exposure: float | None = None, exposures: int | None = None,
            changes: Literal["flip", "color", "depth"] | None = None, change_threshold: str | None = None,
            least_pixels: int | None = None, reference_points: _File | None = None, reference_cloud: _File | None = None,
            test_points: _File | None = None, test_cloud: _File | None = None, partial: bool = False,
            fail_above: _List | None = None, warn_above: _List | None = None, report: _File | None = None,
            reports: _File | None = None, report_pictures: Literal["png", "jpeg"] | None = None,
            color_map: _File | None = None, flip_map: _File | None = None, depth_map: _File | None = None,
            agreement_map: _File | None = None, overwrite: bool = False, workers: int = -1,
            progress: Callable[[int, int], Any] | None = None,
            note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def convert(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
            crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
            crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
            cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
            output: _File | None = None, every: int | None = None, spacing: float | None = None, normals: bool = False,
            geometry: bool = False, group_points: int | None = None, color_depth: float | str | None = None,
            partial: bool = False, memory: int | str | None = None, overwrite: bool = False, workers: int = -1,
            progress: Callable[[int, int], Any] | None = None,
            note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def generate(site: str, *, output: _File | None = None, points: int | None = None, seed: int | None = None,
             overwrite: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
             note: Callable[[str], Any] | None = None) -> Cloud | None: ...
def index(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
          crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
          crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
          cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
          output: _File | None = None, organisation: Literal["adaptive", "fixed", "layered"] | None = None,
          cell_size: float | None = None, stored_order: bool = False, color_depth: float | str | None = None,
          attributes: _List | None = None, spacings: int | None = None, surfaces: bool = False,
          memory: int | str | None = None, checkpoint: _File | None = None, checkpoint_interval: float | None = None,
          resume: bool = False, overwrite: bool = False, partial: bool = False, workers: int = -1,
          progress: Callable[[int, int], Any] | None = None,
          note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def info(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
         crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
         crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
         cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
         stats: bool = False, memory: int | str | None = None, verify: bool = False, partial: bool = False,
         extract_images: _File | None = None, overwrite: bool = False, workers: int = -1,
         progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def sql(cloud: _File | None = None, statement: str | None = None, *, file: _File | None = None,
        param: str | Sequence[str] | None = None, partial: bool = False, cache: _File | None = None,
        allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, workers: int = -1,
        progress: Callable[[int, int], Any] | None = None,
        note: Callable[[str], Any] | None = None) -> Rows | list[Rows]: ...
def sql_load(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
             crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
             crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
             cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
             table: str | None = None, chunk_points: int | None = None, overwrite: bool = False,
             memory: int | str | None = None, color_depth: float | str | None = None, partial: bool = False,
             workers: int = -1, progress: Callable[[int, int], Any] | None = None,
             note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def sql_rewrite(statement: str | None = None, *,
                dialect: Literal["datafusion", "duckdb", "postgres", "spark", "sqlite", "trino"] | None = None,
                file: _File | None = None, bounds: _File | None = None, boxes: int | None = None, workers: int = -1,
                progress: Callable[[int, int], Any] | None = None,
                note: Callable[[str], Any] | None = None) -> list[dict[str, Any]]: ...
def sql_shard_plan(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None,
                   where: str | None = None, crop: _File | Sequence[float] | None = None, crop_crs: str | None = None,
                   columns: _List | None = None, crs: str | None = None, reproject: str | None = None,
                   vertical_unit: Literal["m", "ft", "us-ft"] | None = None, cache: _File | None = None,
                   allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
                   output: _File | None = None, shard: str | Sequence[str] | None = None, table: str | None = None,
                   memory: int | str | None = None, color_depth: float | str | None = None, partial: bool = False,
                   workers: int = -1, progress: Callable[[int, int], Any] | None = None,
                   note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
# to here
