// SPDX-License-Identifier: MIT
#pragma once

// What help() prints. The first line of each is the signature that inspect.signature() reads.

namespace alidade::python {

inline constexpr const char* k_module_doc = R"(Ray queries and images of raw point clouds.

>>> import alidade
>>> index = alidade.open("site.laz").index()
>>> hits = index.closest(rays, radius=0.05)      # rays: (n, 6), origins and directions

Positions and lengths are in the unit of the cloud's coordinate reference system, mostly metres.
Every function takes whole arrays, releases the GIL and uses all cores; `workers` limits the
threads. Ctrl-C ends long work, mostly within a fraction of a second. `progress`, a function of the
work done and all work, is called a few times per second; what it raises ends the work. Clouds and
indexes never change, so threads can share them. Invalid input raises alidade.Error, a ValueError.)";

inline constexpr const char* k_cloud_doc = R"(Cloud(xyz, *, crs=None, scale=None, **attributes)
--

Points and their attributes as arrays.

Parameters
----------
xyz : (n, 3) array of real numbers
    World coordinates. They are rounded to a lattice of `scale`; `cloud.xyz` returns the rounded ones.
crs : str, optional
    Coordinate reference system: WKT, or "EPSG:n".
scale : float, optional
    Step of the lattice. Default: the finest power of ten at which 32 bits hold all coordinates.
**attributes
    Columns of n values: color (n, 3; uint8 or uint16), normal (n, 3), intensity, classification,
    return_number, number_of_returns, flags, scan_angle, user_data, point_source_id, gps_time,
    near_infrared; any other name makes an extra dimension.

Notes
-----
cloud["intensity"] is a read-only array that shares the cloud's memory. color has 16 bits per
channel. Extra dimensions with a scale or a no-data value are returned as scaled doubles, with NaN for
no value.)";

inline constexpr const char* k_index_doc = R"(A cloud with an octree, which answers queries exactly.

Made by Cloud.index(), or by alidade.open() of an .alidade file, which is mapped and not read.

Every answer is that of a test of all points in double precision. Conditions of all queries:

where : (n,) array of bool, optional
    Only points for which it is True.
classes : sequence of int, optional
    Only points of these classes.
max_level : int, optional
    Of an index of organisation "layered": only the levels 0 to max_level, a thinned cloud.
workers : int
    Threads; all cores if below 1.

Pass rays as `rays` of shape (..., 6), origin and direction, or as `origins` and `directions` of
shape (..., 3), one of which may have shape (3,). Directions need not have length 1; positions `t` along a ray
are lengths. Answers have the leading shape of the rays.)";

inline constexpr const char* k_keys_doc =
    "keys()\n--\n\nNames of the attributes that the cloud has, in a list.";
inline constexpr const char* k_xyz_doc =
    "World coordinates, (n, 3) doubles, read-only. They are computed when first asked for, and kept.";
inline constexpr const char* k_bounds_doc = "Smallest box around all points: (2, 3), lower and upper corner.";
inline constexpr const char* k_crs_doc =
    "Coordinate reference system as the file states it (with the unit of converted heights): WKT, or "
    "\"EPSG:n\" for GeoTIFF keys; None if unknown.";
inline constexpr const char* k_scale_doc = "Step of the coordinates' lattice in x, y and z.";

inline constexpr const char* k_make_index_doc =
    R"(index(*, organisation='adaptive', surfaces=False, workers=-1, progress=None)
--

Build the octree: about 0.05 s per million points and core, and 11 bytes per point.

Parameters
----------
organisation : {'adaptive', 'layered'}
    layered: coarse levels are thinned clouds (max_level of queries).
surfaces : bool
    Also fit the surface of every point, which visible() and viewshed() otherwise do again for each
    call, and render() where rays look: some 1 s per million points and core, 7 bytes per point.

Returns
-------
Index)";

inline constexpr const char* k_write_doc = R"(write(file, *, overwrite=False, progress=None)
--

Write the cloud as .las, .laz or .ply, completely or not at all.)";

inline constexpr const char* k_save_doc = R"(save(file, *, overwrite=False, progress=None)
--

Write points, attributes and octree as an index file, .alidade, which alidade.open() maps.)";

inline constexpr const char* k_open_doc =
    R"(open(files, *, partial=False, classes=None, ignore_classes=None, where=None, crop=None, )"
    R"(crop_crs=None, columns=None, crs=None, reproject=None, vertical_unit=None, cache=None, )"
    R"(allow_host=None, cache_size=None, yes=False, workers=-1, progress=None)
--

Open LAS, LAZ, COPC, PLY, PCD, E57, PTX, PTS, CSV, XYZ, .alidade, SQLite and PostgreSQL clouds.

Parameters
----------
files : str, path, or a list of them
    Files, folders, patterns such as 'tiles/*.laz', 'https://...', 'site.db?table=NAME',
    'postgresql://...'. Several are joined in their order.
partial : bool
    Read the intact part of damaged files, with a warning; otherwise damage raises Error.
classes, ignore_classes, where, crop, crop_crs : optional
    Only some of the points, as `alidade convert` selects them: crop=(x0, y0, x1, y1),
    where="z < 610 AND intensity > 100".
crs, reproject, vertical_unit, columns : optional
    Reference system of clouds that state none, another one to bring the points to, the unit of
    heights, and the columns of text without titles.
cache, cache_size, allow_host, yes : optional
    Of files on the web. Index files there are fetched whole, more than 1 GB only with yes=True.

Returns
-------
Cloud, or Index for a single .alidade file without a selection. Heights in another unit than x and y are
converted to that of x and y, with a warning; `crs` then has that unit.)";

inline constexpr const char* k_closest_doc =
    R"(closest(rays=None, *, origins=None, directions=None, radius=None, measure=None, t_min=0.0, )"
    R"(t_max=None, where=None, classes=None, max_level=None, workers=-1)
--

The first point of each ray.

Parameters
----------
radius : float
    Only points at most this far from the ray's line; without it all, for 't' and 'distance'.
measure : {'entry', 't', 'distance'}
    What comes first: where the ray enters the sphere of `radius` around the point, the point's
    projection on the ray, or the distance to the ray's line. As for `alidade query --ray`, 'entry'
    with a radius and 'distance' without, unless given.
t_min, t_max : float or array
    Limits of the projection on the ray, inclusive. A ray begins at its origin; t_min=-inf asks along
    the whole line.

Returns
-------
Hits
    index (int64, -1 where no point answers), t, distance, entry (nan where no point answers).)";

inline constexpr const char* k_nearest_doc =
    R"(nearest(rays=None, *, origins=None, directions=None, radius=None, measure='distance', t_min=0.0, )"
    R"(t_max=None, where=None, classes=None, max_level=None, workers=-1, k=1)
--

The k points nearest to each ray, or the first ones by another measure; parameters as of closest().

Returns
-------
Hits
    index, t, distance, entry of shape (..., k), with -1 and nan where fewer points answer.)";

inline constexpr const char* k_within_doc =
    R"(within(rays=None, *, origins=None, directions=None, radius=None, measure=None, t_min=0.0, )"
    R"(t_max=None, where=None, classes=None, max_level=None, workers=-1, k=0)
--

All points within the radius of each ray, or the first k, ordered by the measure.

Returns
-------
HitLists
    index, t, distance, entry of all rays one after the other; those of ray i (in C order) are
    offsets[i] to offsets[i + 1] - 1.)";

inline constexpr const char* k_occluded_doc =
    R"(occluded(rays=None, *, origins=None, directions=None, radius=None, measure='distance', t_min=0.0, )"
    R"(t_max=None, where=None, classes=None, max_level=None, workers=-1)
--

Whether any point is within the radius of each ray: an array of bool. Parameters as of closest().)";

inline constexpr const char* k_count_doc =
    R"(count(rays=None, *, origins=None, directions=None, radius=None, measure='distance', t_min=0.0, )"
    R"(t_max=None, where=None, classes=None, max_level=None, workers=-1, k=0)
--

How many points are within the radius of each ray, at most k unless that is 0: int64.)";

inline constexpr const char* k_nearest_points_doc =
    R"(nearest_points(xyz, k=1, *, radius=None, where=None, classes=None, max_level=None, workers=-1)
--

The k nearest points of each position (..., 3), by distance, then by index.

Returns
-------
Neighbours
    index and distance of shape (..., k), with -1 and inf where fewer points answer.)";

inline constexpr const char* k_points_within_doc =
    R"(points_within(xyz, radius, *, where=None, classes=None, max_level=None, workers=-1)
--

All points within the radius of each position (..., 3).

Returns
-------
NeighbourLists
    index and distance, nearest first; those of position i are offsets[i] to offsets[i + 1] - 1.)";

inline constexpr const char* k_in_box_doc =
    R"(in_box(boxes, *, where=None, classes=None, max_level=None, workers=-1)
--

All points in each box (..., 6): lower corner, upper corner, faces included.

Returns
-------
PointLists
    index, ascending; those of box i are offsets[i] to offsets[i + 1] - 1.)";

inline constexpr const char* k_in_cone_doc =
    R"(in_cone(rays, angle, *, radius=0.0, t_max=None, where=None, classes=None, max_level=None, workers=-1)
--

All points in the cone around each ray (..., 6), by their position along it.

Parameters
----------
angle : float
    Half the opening angle, degrees, 0 to below 90.
radius : float
    Of the cone at its apex, as of a laser beam.

Returns
-------
HitLists)";

inline constexpr const char* k_along_doc =
    R"(along(path, radius, *, where=None, classes=None, max_level=None, workers=-1)
--

All points within the radius of a path (m, 3), in the order of the way.

Returns
-------
PathHits
    index, segment (number of its first vertex), t (way from the first vertex), distance.)";

inline constexpr const char* k_render_doc =
    R"(render(index, *, camera=None, scene=None, size=(1200, 800), samples=None, layers=['color'], )"
    R"(exposure=None, seed=None, workers=-1, progress=None)
--

Path-trace an image of the cloud.

Parameters
----------
camera : dict, JSON or path, optional
    A camera as in docs/cameras.md. Default: an overview of `size`, of medium brightness.
scene : dict or JSON, optional
    Light, colours and radii as in docs/scene_format.md. Its "cloud" needs no file.
samples : int, optional
    Paths per pixel. Default: 16 for overviews, else the scene's.
layers : list of str
    color, depth, distance, normal, position, albedo, id, variance, depth.sigma, coverage, support.
exposure : float, optional
    Brightness of 'image' in stops. Default: automatic for overviews, else the scene's.

Returns
-------
dict of arrays
    With the layer color: image (sRGB, 8 bits, (height, width, 3)), color (linear light), alpha.
    The others by their names; id is index + 1, 0 where nothing is seen.)";

inline constexpr const char* k_visible_doc =
    R"(visible(index, observers, *, height=None, max_distance=None, transparency=1, workers=-1, progress=None)
--

Which points each observer sees: an array of bool of shape (m, n), or (n,) for one observer.

Parameters
----------
observers : (m, 3) or (m, 2) array, or one of them
    Feet with z (height 0 by default) or on the ground (height 2 by default).
height : float, optional
    Of the eye above the foot.
transparency : int
    Number of separate surfaces that block the view: 1 for solid things, more to see through foliage.)";

inline constexpr const char* k_viewshed_doc =
    R"(viewshed(index, observers, resolution, *, mode='visible', extent=None, height=None, )"
    R"(target_height=0.0, max_distance=None, transparency=1, workers=-1, progress=None)
--

The map of what observers see of the ground, or of things `target_height` above it.

Parameters
----------
observers : as of visible()
resolution : float
    Size of a cell.
mode : {'visible', 'count', 'height', 'fraction'}
    1 or 0; number of observers; lowest visible height; share of free lines of sight.
extent : (x_min, y_min, x_max, y_max), optional

Returns
-------
Raster
    values (rows, columns; nan: no ground, -1: out of reach), transform (as affine.Affine takes
    it: rasterio's transform), crs.)";

inline constexpr const char* k_compare_doc = R"(compare(reference, test, *, workers=-1)
--

Differences of two images (height, width, 3): uint8 or uint16 (sRGB) or floats (linear light).

Returns
-------
Comparison
    flip (mean, 0: equal), ssim, ms_ssim, psnr (dB), rmse, flip_map (height, width).)";

}  // namespace alidade::python
