# SPDX-License-Identifier: MIT
from ._answers import (Change, Comparison, HitLists, Hits, Map, NeighbourLists, Neighbours, PathHits, PointLists, Points, Raster,
                       RenderedImage, Rendering, Rows)
from ._alidade import Cloud, Error, Index, __doc__, __version__, compare, open, render, viewshed, visible
from . import jobs, visibility
from ._jobs import added_jobs as _added_jobs
# Jobs of extensions that are in no group.
globals().update({name: getattr(jobs, name) for name in _added_jobs(lambda command: " " not in command)})
