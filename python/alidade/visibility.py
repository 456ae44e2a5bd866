# SPDX-License-Identifier: MIT
"""What is visible, as `alidade visibility` computes it.

The fields are the options of the program, with _ for -. Their values are numbers, texts, True for options without a value,
sequences where the program takes a list, such as extent=(x0, y0, x1, y1), and sequences of sequences where an option may be
repeated, such as observer=[(x, y), (x, y, z)]."""
from ._jobs import added_jobs as _added_jobs, job as _job

raster = _job("visibility raster", "Compute a viewshed of the ground, or of objects from the ground: an alidade.Map.")
points = _job("visibility points", "Compute the visibility of every point, and what blocks it: alidade.Points, with rows of observers.")
horizon = _job("visibility horizon", "Compute the horizon and sky-view factors at one position: alidade.Rows, one per azimuth.")
sky = _job("visibility sky", "Compute sky-view factors: alidade.Points, or an alidade.Map of the ground with a field of maps, such as `resolution`.")
sun = _job("visibility sun", "Compute hours of direct sun: alidade.Points; with a field of maps a dict of alidade.Map; for observers "
           "alidade.Rows.")
lines = _job("visibility lines", "Test lines of sight between pairs of positions: alidade.Rows, one per line.")
summary = _job("visibility summary", "Summarize what each observer sees: alidade.Rows, one per observer.")
globals().update(_added_jobs(lambda command: command.startswith("visibility ")))
