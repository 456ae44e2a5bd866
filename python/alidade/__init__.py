# SPDX-License-Identifier: MIT
from ._answers import Comparison, HitLists, Hits, Map, NeighbourLists, Neighbours, PathHits, PointLists, Raster
from ._alidade import Cloud, Error, Index, __doc__, __version__, compare, open, render, viewshed, visible
from . import visibility
