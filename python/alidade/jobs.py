# SPDX-License-Identifier: MIT
"""The other commands of the program on files, as alidade.visibility has those of `alidade visibility`: their fields are the
options, with _ for -."""
from ._jobs import added_jobs as _added_jobs, job as _job

info = _job("info", "Describe cloud files: what --json prints, as a dict.")
generate = _job("generate", "Simulate a scan of a courtyard: an alidade.Cloud, or None with an output.")
index = _job("index", "Build an index file, which replaces cloud files: a dict with its size.")
catalog = _job("catalog", "List many clouds with their bounds, so that few need be opened: a dict with the number of files.")
convert = _job("convert", "Convert, join, crop and thin clouds: a dict with the number of points.")
query = _job("query", "Find the points near rays, paths and positions, and in cones, planes and boxes, which may be arrays: alidade.Rows.")
render = _job("render", "Render images of a scene or of clouds, depth maps and rasters of the ground: an alidade.Rendering.")
merge = _job("merge", "Join the parts of an image that machines have rendered: an alidade.RenderedImage.")
compare = _job("compare", "Compare images of files, folders or a table of pairs: what --json prints, as a dict.")
sql = _job("sql", "Query a cloud with SQL: alidade.Rows of the statement, or a list of them.")
sql_load = _job("sql load", "Store a cloud in a database: a dict with the number of points.")
sql_rewrite = _job("sql rewrite", "Rewrite statements for engines without dist_ray: a list of dicts.")
globals().update(_added_jobs(lambda command: not command.startswith("visibility ")))
