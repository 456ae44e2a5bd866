# SPDX-License-Identifier: MIT
"""What goes in and out of the other libraries of remote sensing, each left out where it is not installed."""
import alidade
import numpy as np
import pytest

EYE = [689995, 5324983.5, 601.7]


def library(name: str):
    """A module of the Debian package python3-NAME."""
    package = "python3-" + name.split(".")[0]
    return pytest.importorskip(name, reason=f"left out: {package} is not installed")


@pytest.fixture(scope="module")
def viewshed(index) -> alidade.Raster:
    return alidade.viewshed(index, [EYE, [690005, 5325010, 601.7]], 1.0, mode="count")


def cell_of(raster: alidade.Raster, position) -> tuple:
    """Row and column of the cell around a position."""
    cell, _, left, _, _, top = raster.transform
    return int((top - position[1]) / cell), int((position[0] - left) / cell)


def test_attributes_are_columns_of_pandas(index):
    pandas = library("pandas")
    names = [name for name in index.keys() if index[name].ndim == 1]
    frame = pandas.DataFrame({name: index[name] for name in names})
    frame[["x", "y", "z"]] = index.xyz
    highest = frame.groupby("classification")["z"].max()
    assert len(highest) > 2
    for number, height in highest.items():
        assert height == index.xyz[index["classification"] == number, 2].max()

    ground = frame[frame["classification"] == 2]
    part = alidade.Cloud(ground[["x", "y", "z"]], scale=index.scale[0], **{name: ground[name] for name in names})
    assert 0 < len(part) < len(index)
    np.testing.assert_allclose(part.xyz, ground[["x", "y", "z"]], atol=1e-9, rtol=0)
    for name in names:
        np.testing.assert_array_equal(part[name], ground[name])
        assert part[name].dtype == index[name].dtype

    above = ground.sample(50, random_state=1)
    rays = pandas.DataFrame({"x": above["x"], "y": above["y"], "z": above["z"] + 0.01, "dx": 0, "dy": 0, "dz": -1.0})
    met = frame["z"].to_numpy()[index.closest(rays, radius=0.02).index] - above["z"]
    assert (met >= -1e-9).all() and (met <= 0.01 + 1e-9).all()


def test_images_and_maps_are_shown_by_matplotlib(index, viewshed, tmp_path):
    matplotlib = library("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    picture = alidade.render(index, size=(90, 60), samples=2)["image"]
    plt.imsave(tmp_path / "overview.png", picture)
    stored = plt.imread(tmp_path / "overview.png")
    np.testing.assert_array_equal(np.round(255 * stored[..., :3]), picture)

    # One pixel of the figure for each cell of the map: cells without ground stay white.
    rows, columns = viewshed.values.shape
    cell, _, left, _, _, top = viewshed.transform
    figure = plt.figure(figsize=(columns / 100, rows / 100), dpi=100)
    axes = figure.add_axes([0, 0, 1, 1])
    axes.imshow(viewshed.values, cmap="gray", vmin=-1, vmax=4, interpolation="nearest", aspect="auto",
                extent=(left, left + columns * cell, top - rows * cell, top))
    axes.axis("off")
    figure.savefig(tmp_path / "map.png", dpi=100)
    gray = plt.imread(tmp_path / "map.png")[..., 0]
    assert gray.shape == viewshed.values.shape
    is_ground = ~np.isnan(viewshed.values)
    assert is_ground.any() and not is_ground.all()
    np.testing.assert_allclose(gray[is_ground], (viewshed.values[is_ground] + 1) / 5, atol=1 / 128)
    assert (gray[~is_ground] == 1).all()
    # Pixels count from below.
    x, y = axes.transData.transform(EYE[:2])
    assert (rows - 1 - int(y), int(x)) == cell_of(viewshed, EYE)
    plt.close(figure)


def test_viewsheds_are_written_and_read_by_rasterio(index, viewshed, tmp_path):
    rasterio = library("rasterio")
    file = tmp_path / "count.tif"
    with rasterio.open(file, "w", driver="GTiff", height=viewshed.values.shape[0], width=viewshed.values.shape[1],
                       count=1, dtype=viewshed.values.dtype, nodata=np.nan, crs=viewshed.crs,
                       transform=rasterio.Affine(*viewshed.transform)) as target:
        target.write(viewshed.values, 1)
    with rasterio.open(file) as source:
        np.testing.assert_array_equal(source.read(1), viewshed.values)
        assert tuple(source.transform)[:6] == viewshed.transform
        assert source.crs.to_epsg() == 32632 and np.isnan(source.nodata)
        assert source.index(*EYE[:2]) == cell_of(viewshed, EYE)
        assert source.bounds.left <= index.bounds[0, 0] and source.bounds.top >= index.bounds[1, 1]
        # Each observer sees the ground at their feet.
        assert next(source.sample([EYE[:2]]))[0] >= 1


def test_points_and_areas_are_those_of_geopandas(index):
    geopandas = library("geopandas")
    from shapely.geometry import box

    xyz = index.xyz[::10]
    frame = geopandas.GeoDataFrame({"classification": index["classification"][::10]},
                                   geometry=geopandas.points_from_xy(*xyz.T, crs=index.crs))
    assert frame.crs.to_epsg() == 32632
    np.testing.assert_array_equal(frame.geometry.z, xyz[:, 2])

    low, high = [689990, 5324990], [690002, 5325001]
    inside = frame[frame.intersects(box(*low, *high))]
    found = index.in_box([*low, -np.inf, *high, np.inf]).index
    assert len(inside) > 10 and set(10 * inside.index) == set(found[found % 10 == 0])

    # Observers from a layer in degrees.
    layer = geopandas.GeoSeries.from_xy([EYE[0]], [EYE[1]], crs=index.crs).to_crs(4326)
    assert 8 < layer.x[0] < 16
    moved = layer.to_crs(index.crs)
    seen = alidade.viewshed(index, np.column_stack([moved.x, moved.y]), 2.0)
    expected = alidade.viewshed(index, [EYE[:2]], 2.0)
    assert seen.transform == expected.transform
    assert np.isclose(seen.values, expected.values, equal_nan=True).mean() > 0.99


def test_rasters_are_arrays_of_xarray(index, viewshed, rays, scattered):
    xarray = library("xarray")
    cell, _, left, _, step, top = viewshed.transform
    rows, columns = viewshed.values.shape
    raster = xarray.DataArray(viewshed.values, dims=("y", "x"), attrs={"crs": viewshed.crs},
                              coords={"y": top + step * (np.arange(rows) + 0.5), "x": left + cell * (np.arange(columns) + 0.5)})
    assert raster.sel(x=EYE[0], y=EYE[1], method="nearest") == viewshed.values[cell_of(viewshed, EYE)]
    # The ground of classified points has cells of the map, and all points lie within its coordinates.
    ground = index.xyz[index["classification"] == 2][::50]
    values = raster.sel(x=xarray.DataArray(ground[:, 0], dims="point"), y=xarray.DataArray(ground[:, 1], dims="point"),
                        method="nearest", tolerance=cell / 2 + 1e-6)
    assert np.isfinite(values).mean() > 0.9
    both = raster.where(raster == 2)
    assert int(both.count()) == (viewshed.values == 2).sum() > 0

    fan = xarray.DataArray(rays.reshape(20, 25, 6), dims=("row", "column", "part"))
    hits = scattered.closest(fan, radius=0.2)
    assert (hits.index == scattered.closest(rays, radius=0.2).index.reshape(20, 25)).all()


def test_clouds_and_rays_are_those_of_open3d(scattered):
    open3d = library("open3d")
    # Open3D takes no read-only arrays.
    points = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(scattered.xyz.copy()))
    assert alidade.Cloud(np.asarray(points.points), scale=1e-6).xyz.tolist() == scattered.xyz.tolist()
    tree = open3d.geometry.KDTreeFlann(points)
    for position in scattered.xyz[:20] + 0.1:
        _, indices, squares = tree.search_knn_vector_3d(position, 5)
        found = scattered.nearest_points(position, k=5)
        assert found.index.tolist() == list(indices)
        np.testing.assert_allclose(found.distance**2, squares, rtol=1e-9)

    # Its rays, with directions of any length: the answers are metres.
    side = np.arange(-3, 3.01, 0.05)
    wall = np.stack(np.meshgrid([4.0], side, side), axis=-1).reshape(-1, 3)
    index = alidade.Cloud(wall, scale=1e-3).index()
    rays = open3d.t.geometry.RaycastingScene.create_rays_pinhole(
        fov_deg=100, center=[4, 0, 0], eye=[0, 0.3, 0.2], up=[0, 0, 1], width_px=60, height_px=40).numpy()
    assert rays.dtype == np.float32 and rays.shape == (40, 60, 6)
    origins, directions = rays[..., :3].astype(float), rays[..., 3:].astype(float)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    way = (4 - origins[..., :1]) / directions[..., :1]
    meets = (np.abs((origins + way * directions)[..., 1:]) <= 3).all(axis=-1)
    hits = index.closest(rays, radius=0.06)
    assert 0.3 < meets.mean() < 0.9 and (hits.index[meets] >= 0).all()
    # Around the edge, spheres reach beyond the wall.
    assert ((hits.index >= 0) == meets).mean() > 0.95
    assert np.abs(hits.t - way[..., 0])[meets].max() < 0.1
