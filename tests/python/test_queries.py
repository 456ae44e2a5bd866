# SPDX-License-Identifier: MIT
import alidade
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp


def projections(xyz, rays):
    """Positions along the rays and distances to their lines: (rays, points)."""
    directions = rays[:, 3:] / np.linalg.norm(rays[:, 3:], axis=1, keepdims=True)
    offsets = xyz[None] - rays[:, None, :3]
    t = np.einsum("rpc,rc->rp", offsets, directions)
    return t, np.linalg.norm(offsets - t[..., None] * directions[:, None], axis=2)


def test_closest_is_the_first_sphere_of_all(scattered, rays):
    t, distance = projections(scattered.xyz, rays)
    radius = 0.05
    entry = np.where((distance <= radius) & (t >= 0), t - np.sqrt(np.maximum(radius**2 - distance**2, 0)), np.inf)
    hits = scattered.closest(rays, radius=radius)
    first = entry.argmin(1)
    expected = np.where(np.isfinite(entry.min(1)), first, -1)
    assert (hits.index == expected).all()
    seen = expected >= 0
    assert 0.1 < seen.mean() < 0.95
    np.testing.assert_allclose(hits.entry[seen], entry.min(1)[seen], atol=1e-9)
    assert np.isnan(hits.t[~seen]).all()
    assert (scattered.occluded(rays, radius=radius) == seen).all()


def test_nearest_within_and_count_agree(scattered, rays):
    t, distance = projections(scattered.xyz, rays)
    distance = np.where(t >= 0, distance, np.inf)
    nearest = scattered.nearest(rays, k=5)
    np.testing.assert_allclose(nearest.distance, np.sort(distance, 1)[:, :5], atol=1e-9)
    lists = scattered.within(rays, radius=0.5)
    counts = (distance <= 0.5).sum(1)
    assert (np.diff(lists.offsets) == counts).all() and (scattered.count(rays, radius=0.5) == counts).all()
    for i in (0, 17, 499):
        part = slice(lists.offsets[i], lists.offsets[i + 1])
        assert (np.diff(lists.entry[part]) >= 0).all()
        assert set(lists.index[part]) == set(np.flatnonzero(distance[i] <= 0.5))


def test_lists_of_many_targets_are_those_of_each(scattered):
    few = scattered.xyz[:100]
    of_few, of_many = (scattered.points_within(xyz, radius=0.5) for xyz in (few, np.tile(few, (300, 1))))
    assert (np.diff(of_many.offsets) == np.tile(np.diff(of_few.offsets), 300)).all()
    assert (of_many.index == np.tile(of_few.index, 300)).all()


def test_masks_and_classes_choose_points(scattered, rays):
    classes = np.asarray(scattered["classification"])
    hits = scattered.closest(rays, radius=0.3, classes=[2, 4])
    assert set(classes[hits.index[hits.index >= 0]]) == {2, 4}
    mask = np.isin(classes, [2, 4])
    assert (scattered.closest(rays, radius=0.3, where=mask).index == hits.index).all()
    assert (scattered.closest(rays, radius=0.3, where=np.repeat(mask, 2)[::2]).index == hits.index).all()
    assert (scattered.nearest_points(rays[:, :3], k=3, where=mask, classes=[2]).index % 5 == 2).all()
    with pytest.raises(alidade.Error, match="bool of shape"):
        scattered.closest(rays, radius=0.3, where=mask[:-1])
    with pytest.raises(alidade.Error, match="bool of shape"):
        scattered.closest(rays, radius=0.3, where=classes)
    with pytest.raises(alidade.Error, match="0 to 255"):
        scattered.closest(rays, radius=0.3, classes=[256])


def test_neighbours_equal_those_of_scipy():
    spatial = pytest.importorskip("scipy.spatial")
    rng = np.random.default_rng(3)
    cloud = alidade.Cloud(rng.normal(size=(200_000, 3)), scale=1e-8)
    index = cloud.index()
    where = rng.normal(size=(5000, 3))
    distances, indices = spatial.cKDTree(cloud.xyz).query(where, k=8)
    found = index.nearest_points(where, k=8)
    assert (found.index == indices).all()
    np.testing.assert_allclose(found.distance, distances, rtol=1e-12)
    lists = index.points_within(where[:100], 0.05)
    expected = spatial.cKDTree(cloud.xyz).query_ball_point(where[:100], 0.05)
    for i, ids in enumerate(expected):
        assert set(lists.index[lists.offsets[i]:lists.offsets[i + 1]]) == set(ids)
    few = alidade.Cloud([[0, 0, 0]]).index().nearest_points([[1, 0, 0]], k=2)
    assert few.index.tolist() == [[0, -1]] and few.distance.tolist() == [[1, np.inf]]


def test_boxes_cones_and_paths(scattered):
    xyz = scattered.xyz
    boxes = np.array([[1, 1, 0, 4, 5, 1], [6, 6, 0, 6.5, 9, 2.0]])
    lists = scattered.in_box(boxes)
    for i, box in enumerate(boxes):
        inside = np.flatnonzero((xyz >= box[:3]).all(1) & (xyz <= box[3:]).all(1))
        assert lists.index[lists.offsets[i]:lists.offsets[i + 1]].tolist() == inside.tolist()
    axis = np.array([0, 0, 1, 1, 1, 0.0])
    cone = scattered.in_cone(axis, 5.0, t_max=8)
    t, distance = projections(xyz, axis[None])
    expected = (t[0] >= 0) & (t[0] <= 8) & (distance[0] <= t[0] * np.tan(np.radians(5)))
    assert set(cone.index) == set(np.flatnonzero(expected)) and cone.index.size > 5
    path = scattered.along([[1, 1, 1], [5, 1, 1], [5, 5, 1]], 0.4)
    assert (path.distance <= 0.4).all() and (np.diff(path.t) >= 0).all() and set(path.segment) == {0, 1}


def test_shapes_of_rays_are_those_of_answers(scattered, rays):
    grid = rays[:60].reshape(3, 4, 5, 6)
    flat = scattered.closest(rays[:60], radius=0.3)
    assert scattered.closest(grid, radius=0.3).index.tolist() == flat.index.reshape(3, 4, 5).tolist()
    assert scattered.nearest(grid, k=2).index.shape == (3, 4, 5, 2)
    assert scattered.closest(rays[0], radius=0.3).index.shape == ()
    assert scattered.closest(np.empty((0, 6)), radius=0.3).index.shape == (0,)
    same = scattered.closest(origins=rays[:, :3], directions=rays[:, 3:], radius=0.3)
    assert (same.index == scattered.closest(rays, radius=0.3).index).all()
    fan = scattered.closest(origins=[5, 5, 1], directions=rays[:, 3:], radius=0.3)
    assert fan.index.shape == (500,)
    limited = scattered.closest(rays, radius=0.3, t_min=np.linspace(0, 9, 500), t_max=10)
    assert (limited.t[limited.index >= 0] <= 10).all()


@pytest.mark.parametrize("arguments, words", [
    (dict(rays=np.ones((3, 5)), radius=1), ["(..., 6)", "(3, 5)", "float64"]),
    (dict(rays=[0, 0, 0, 0, 0, 0], radius=1), ["ray 0", "zero"]),
    (dict(rays=[[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, np.nan, 1]], radius=1), ["ray 1", "finite"]),
    (dict(radius=1), ["rays", "origins"]),
    (dict(origins=np.ones((3, 3)), directions=np.ones((4, 3)), radius=1), ["different shapes"]),
    (dict(rays=[0, 0, 0, 0, 0, 1], radius=-1), ["radius"]),
    (dict(rays=[0, 0, 0, 0, 0, 1], radius=np.nan), ["radius"]),
    (dict(rays=[0, 0, 0, 0, 0, 1], measure="entry"), ["radius"]),
    (dict(rays=[0, 0, 0, 0, 0, 1], radius=1, measure="first"), ["entry, distance or t", "first"]),
    (dict(rays=[[0, 0, 0, 0, 0, 1]] * 2, radius=1, t_min=[1, 2, 3]), ["t_min", "(2)", "(3,)"]),
    (dict(rays=np.ones((2, 3, 6)), radius=1, t_max=np.ones((3, 2))), ["t_max", "(2, 3)", "(3, 2)"]),
    (dict(rays=[0, 0, 0, 0, 0, 1], radius=1, max_level=1), ["layered"]),
])
def test_wrong_rays_are_errors_that_say_what_is_expected(scattered, arguments, words):
    with pytest.raises(alidade.Error) as error:
        scattered.closest(**arguments)
    for word in words:
        assert word in str(error.value)


def test_other_requests_out_of_range_are_errors(scattered, rays):
    with pytest.raises(alidade.Error, match="k is out of range"):
        scattered.nearest(rays, k=0)
    with pytest.raises(alidade.Error, match="(m, 3)"):
        scattered.along(np.zeros((2, 2, 3)), 1)
    few = scattered.closest(rays, radius=0.3, workers=1).index
    assert (scattered.closest(rays, radius=0.3, workers=2**31 - 1).index == few).all()


def test_levels_of_a_layered_index_thin_the_cloud(yard):
    index = alidade.open(yard).index(organisation="layered")
    box = index.bounds.ravel()
    sizes = [index.in_box(box, max_level=level).index.size for level in (0, 2, 99)]
    assert 0 < sizes[0] < sizes[1] < sizes[2] == len(index)


shapes = hnp.array_shapes(min_dims=0, max_dims=3, max_side=7)
numbers = hnp.arrays(dtype=st.one_of(hnp.floating_dtypes(), hnp.integer_dtypes(), hnp.boolean_dtypes(),
                                     hnp.complex_number_dtypes(), hnp.unicode_string_dtypes()), shape=shapes)
anything = st.one_of(numbers, st.none(), st.text(max_size=5), st.integers(), st.floats(),
                     st.lists(st.floats(), max_size=6))


@settings(max_examples=300, deadline=None)
@given(first=anything, second=anything, number=st.one_of(st.none(), st.floats(), st.integers(-3, 3)))
def test_any_input_is_answered_or_rejected(scattered, first, second, number):
    calls = (lambda: scattered.closest(first, radius=number), lambda: scattered.nearest(first, k=3, t_min=second),
             lambda: scattered.within(origins=first, directions=second, radius=number, k=2),
             lambda: scattered.occluded(first, radius=1, where=second),
             lambda: scattered.nearest_points(first, k=2, radius=number), lambda: scattered.in_box(first),
             lambda: scattered.in_cone(first, number), lambda: scattered.along(first, number),
             lambda: alidade.Cloud(first, intensity=second), lambda: alidade.Cloud(first, extra=second, scale=number),
             lambda: alidade.compare(first, second), lambda: alidade.visible(scattered, first, height=number))
    for call in calls:
        try:
            call()
        except (alidade.Error, TypeError):
            pass
