# SPDX-License-Identifier: MIT
"""What queries return: named tuples of arrays."""
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from numpy import float32, float64, int64
from numpy.typing import NDArray


class Hits(NamedTuple):
    """Points of rays, in the shape of the rays; index -1 and nan where no point answers."""
    index: NDArray[int64]  # type: ignore[assignment]
    t: NDArray[float64]
    distance: NDArray[float64]
    entry: NDArray[float64]


class HitLists(NamedTuple):
    """All points of rays, one ray after the other: those of ray i are offsets[i] to offsets[i + 1] - 1."""
    index: NDArray[int64]  # type: ignore[assignment]
    offsets: NDArray[int64]
    t: NDArray[float64]
    distance: NDArray[float64]
    entry: NDArray[float64]


class Neighbours(NamedTuple):
    """Points near positions, nearest first; index -1 and distance inf where fewer answer."""
    index: NDArray[int64]  # type: ignore[assignment]
    distance: NDArray[float64]


class NeighbourLists(NamedTuple):
    """All points near positions: those of position i are offsets[i] to offsets[i + 1] - 1."""
    index: NDArray[int64]  # type: ignore[assignment]
    offsets: NDArray[int64]
    distance: NDArray[float64]


class PointLists(NamedTuple):
    """All points in boxes: those of box i are offsets[i] to offsets[i + 1] - 1."""
    index: NDArray[int64]  # type: ignore[assignment]
    offsets: NDArray[int64]


class PathHits(NamedTuple):
    """Points along a path: number of the segment's first vertex, way from the first vertex, distance."""
    index: NDArray[int64]  # type: ignore[assignment]
    segment: NDArray[int64]
    t: NDArray[float64]
    distance: NDArray[float64]


class Raster(NamedTuple):
    """A map: values (rows, columns), transform as affine.Affine takes it, coordinate reference system."""
    values: NDArray[float32]
    transform: Tuple[float, ...]
    crs: Optional[str]


class Map(NamedTuple):
    """A map as the program writes it: values (rows, columns), transform as affine.Affine takes it, coordinate reference
    system, the value of cells without data, and the texts that the file's metadata has."""
    values: NDArray[Any]
    transform: Tuple[float, ...]
    crs: Optional[str]
    nodata: float
    metadata: Dict[str, str]


class Points(NamedTuple):
    """What a job found out about the points of a cloud: columns by point, in the order of the cloud, with the names that
    the job's output has; rows about observers, photos or classes, as columns; coordinate reference system."""
    columns: Dict[str, NDArray[Any]]
    rows: Dict[str, NDArray[Any]]
    crs: Optional[str]


class Rows(NamedTuple):
    """Rows of a job's output: columns by name, coordinate reference system, and facts that are not of a single row. A
    column without a value in every row has numbers, nan where there is none; one of several kinds has objects."""
    columns: Dict[str, NDArray[Any]]
    crs: Optional[str]
    facts: Dict[str, Any]


class Change(NamedTuple):
    """What has changed between two scans, of the points of both; rows are about the classes of change."""
    before: Points
    after: Points


class RenderedImage(NamedTuple):
    """An image of a job: its layers by name, as render() returns them, none if it was written; its file, or None; the name
    of its camera, and the camera with the keys of camera files, None for an image of parts; rays, seconds and samples."""
    layers: Dict[str, NDArray[Any]]
    file: Optional[str]
    name: str
    camera: Optional[Dict[str, Any]]
    statistics: Dict[str, Any]


class Rendering(NamedTuple):
    """Images of a job, the names of all files it wrote, coordinate reference system of the cloud, and the names of views
    that see no surface."""
    images: List[RenderedImage]
    files: List[str]
    crs: Optional[str]
    empty_views: List[str]


class Comparison(NamedTuple):
    """Differences of two images."""
    flip: float
    ssim: float
    ms_ssim: float
    psnr: float
    rmse: float
    flip_map: NDArray[float32]
