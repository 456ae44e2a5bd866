# SPDX-License-Identifier: MIT
"""What queries return: named tuples of arrays."""
from typing import Any, NamedTuple, Optional, Tuple


class Hits(NamedTuple):
    """Points of rays, in the shape of the rays; index -1 and nan where no point answers."""
    index: Any
    t: Any
    distance: Any
    entry: Any


class HitLists(NamedTuple):
    """All points of rays, one ray after the other: those of ray i are offsets[i] to offsets[i + 1] - 1."""
    index: Any
    offsets: Any
    t: Any
    distance: Any
    entry: Any


class Neighbours(NamedTuple):
    """Points near positions, nearest first; index -1 and distance inf where fewer answer."""
    index: Any
    distance: Any


class NeighbourLists(NamedTuple):
    """All points near positions: those of position i are offsets[i] to offsets[i + 1] - 1."""
    index: Any
    offsets: Any
    distance: Any


class PointLists(NamedTuple):
    """All points in boxes: those of box i are offsets[i] to offsets[i + 1] - 1."""
    index: Any
    offsets: Any


class PathHits(NamedTuple):
    """Points along a path: number of the segment's first vertex, way from the first vertex, distance."""
    index: Any
    segment: Any
    t: Any
    distance: Any


class Raster(NamedTuple):
    """A map: values (rows, columns), transform as affine.Affine takes it, coordinate reference system."""
    values: Any
    transform: Tuple[float, ...]
    crs: Optional[str]


class Comparison(NamedTuple):
    """Differences of two pictures."""
    flip: float
    ssim: float
    ms_ssim: float
    psnr: float
    rmse: float
    flip_map: Any
