# SPDX-License-Identifier: MIT
from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Literal

from numpy.typing import ArrayLike

from . import Cloud
from ._answers import RenderedImage, Rendering, Rows

_File = str | PathLike[str]
_Files = _File | Sequence[_File]
_List = int | str | Sequence[int] | Sequence[str]

# Made by tests/python/stubs.py from here
def catalog(files: _Files, *, cache: _File | None = None, allow_host: str | Sequence[str] | None = None,
            cache_size: int | str | None = None, yes: bool = False, output: _File | None = None, measure: bool = False,
            overwrite: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
            note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
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
            yes: bool = False, output: _File | None = None, every: int | None = None, spacing: float | None = None,
            normals: bool = False, geometry: bool = False, group_points: int | None = None,
            color_depth: float | str | None = None, partial: bool = False, memory: int | str | None = None,
            overwrite: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
            note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def generate(site: str, *, output: _File | None = None, points: int | None = None, seed: int | None = None,
             overwrite: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
             note: Callable[[str], Any] | None = None) -> Cloud | None: ...
def index(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
          crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
          crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
          cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
          yes: bool = False, output: _File | None = None,
          organisation: Literal["adaptive", "fixed", "layered"] | None = None, cell_size: float | None = None,
          stored_order: bool = False, color_depth: float | str | None = None, attributes: _List | None = None,
          spacings: int | None = None, surfaces: bool = False, memory: int | str | None = None,
          checkpoint: _File | None = None, checkpoint_interval: float | None = None, resume: bool = False,
          overwrite: bool = False, partial: bool = False, workers: int = -1,
          progress: Callable[[int, int], Any] | None = None,
          note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def info(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
         crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
         crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
         cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
         yes: bool = False, stats: bool = False, memory: int | str | None = None, verify: bool = False,
         partial: bool = False, extract_images: _File | None = None, overwrite: bool = False, workers: int = -1,
         progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def merge(files: _Files, *, output: _File | None = None, overwrite: bool = False, workers: int = -1,
          progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> RenderedImage: ...
def query(files: _Files, *, ignore_classes: _List | None = None, where: str | None = None,
          crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
          crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
          cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
          yes: bool = False, rays: _File | ArrayLike | None = None, ray: str | ArrayLike | None = None,
          lines: _File | ArrayLike | None = None, line: str | ArrayLike | None = None,
          cones: _File | ArrayLike | None = None, cone: str | ArrayLike | None = None,
          path: _File | ArrayLike | None = None, vertex: str | ArrayLike | None = None,
          planes: _File | ArrayLike | None = None, plane: str | ArrayLike | None = None,
          boxes: _File | ArrayLike | None = None, box: str | ArrayLike | None = None,
          points: _File | ArrayLike | None = None, point: str | ArrayLike | None = None, radius: float | None = None,
          k: int | None = None, measure: Literal["distance", "t", "entry"] | None = None, t_min: float | None = None,
          t_max: float | None = None, entry_min: float | None = None, classes: _List | None = None,
          max_level: int | None = None, occluded: bool = False, count: bool = False, precision: int | None = None,
          output: _File | None = None, format: Literal["csv", "jsonl", "las"] | None = None, overwrite: bool = False,
          explain: bool = False, load: bool = False, memory: int | str | None = None, partial: bool = False,
          workers: int = -1, progress: Callable[[int, int], Any] | None = None,
          note: Callable[[str], Any] | None = None) -> Rows: ...
def render(files: _Files | None = None, *, classes: _List | None = None, ignore_classes: _List | None = None,
           where: str | None = None, crop: _File | Sequence[float] | None = None, crop_crs: str | None = None,
           columns: _List | None = None, crs: str | None = None, reproject: str | None = None,
           vertical_unit: Literal["m", "ft", "us-ft"] | None = None, cache: _File | None = None,
           allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, yes: bool = False,
           cloud: _Files | None = None, site: str | None = None, mesh: _Files | None = None, output: _File | None = None,
           in_view: bool = False, overwrite: bool = False, skip_existing: bool = False, camera: _File | None = None,
           camera_name: str | Sequence[str] | None = None, lens: _File | None = None, original_world: bool = False,
           near: float | None = None, panorama: str | ArrayLike | None = None, orthographic: str | None = None,
           size: str | Sequence[int] | None = None, resolution: float | None = None, extent: str | ArrayLike | None = None,
           orbit: bool = False, keyframes: _File | None = None, frames: int | None = None, frame_rate: int | None = None,
           depth: _File | None = None, depth_format: Literal["exr", "png16", "npy", "tiff", "colmap"] | None = None,
           depth_scale: int | None = None, depth_along: Literal["axis", "ray"] | None = None,
           depth_mask: _File | None = None, transforms_out: _File | None = None,
           mode: Literal["path", "ambient_occlusion", "headlight", "flat"] | None = None,
           ao_distance: float | str | None = None, sun: str | ArrayLike | None = None, sun_time: str | None = None,
           sun_place: str | ArrayLike | None = None, no_sun: bool = False, samples: int | None = None,
           max_bounces: int | None = None, exposure: float | str | None = None, transparent: bool = False,
           layers: _List | None = None, seed: int | None = None, radius: float | str | None = None,
           radius_factor: float | None = None, radius_neighbours: int | None = None, radius_max: float | str | None = None,
           color_depth: float | str | None = None, hits: Literal["entry", "t"] | None = None,
           normals: Literal["sphere", "smooth"] | None = None, surface: Literal["sphere", "disc", "blend"] | None = None,
           max_level: int | None = None, color_by: str | None = None,
           color_map: Literal["auto", "viridis", "inferno", "turbo", "terrain", "grey"] | None = None,
           color_range: str | ArrayLike | None = None, color_percentiles: str | ArrayLike | None = None,
           class_color: str | ArrayLike | None = None, legend: _File | None = None,
           legend_size: str | Sequence[int] | None = None, time_limit: float | None = None,
           target_noise: float | None = None, preview: _File | None = None, preview_interval: float | None = None,
           preview_points: int | None = None, checkpoint: _File | None = None, checkpoint_interval: float | None = None,
           resume: bool = False, part: str | Sequence[int] | None = None, partial: bool = False, workers: int = -1,
           progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> Rendering: ...
def sql(cloud: _File | None = None, statement: str | None = None, *, file: _File | None = None,
        param: str | Sequence[str] | None = None, partial: bool = False, cache: _File | None = None,
        allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, yes: bool = False,
        workers: int = -1, progress: Callable[[int, int], Any] | None = None,
        note: Callable[[str], Any] | None = None) -> Rows | list[Rows]: ...
def sql_load(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None, where: str | None = None,
             crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
             crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
             cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
             yes: bool = False, table: str | None = None, chunk_points: int | None = None, overwrite: bool = False,
             memory: int | str | None = None, color_depth: float | str | None = None, partial: bool = False,
             workers: int = -1, progress: Callable[[int, int], Any] | None = None,
             note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
def sql_rewrite(statement: str | None = None, *,
                dialect: Literal["datafusion", "duckdb", "postgres", "spark", "sqlite", "trino"] | None = None,
                file: _File | None = None, bounds: _File | None = None, boxes: int | None = None, workers: int = -1,
                progress: Callable[[int, int], Any] | None = None,
                note: Callable[[str], Any] | None = None) -> list[dict[str, Any]]: ...
# to here
