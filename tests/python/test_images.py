# SPDX-License-Identifier: MIT
import alidade
import numpy as np
import pytest

EYE = [689995, 5324983.5, 601.7]


def test_overviews_show_the_cloud(index):
    picture = alidade.render(index, size=(90, 60), samples=4, layers=["color", "depth", "id", "normal"])
    assert picture["image"].shape == (60, 90, 3) and picture["image"].dtype == np.uint8
    assert picture["image"][0, 0].tolist() == [222, 232, 242]
    seen = picture["id"] > 0
    assert 0.2 < seen.mean() < 0.9 and (np.isfinite(picture["depth"]) == seen).all()
    np.testing.assert_allclose(np.linalg.norm(picture["normal"][seen], axis=1), 1, atol=1e-3)
    assert (picture["id"][seen] <= len(index)).all()
    again = alidade.render(index, size=(90, 60), samples=4, workers=1)
    assert (again["image"] == picture["image"]).all()


def test_cameras_and_scenes_are_those_of_the_program(index):
    camera = {"model": "pinhole", "width": 60, "height": 40, "intrinsics": {"vertical_fov": 60},
              "pose": {"look_at": {"eye": EYE, "target": [690000, 5325000, 601]}}}
    flat = alidade.render(index, camera=camera, scene={"render": {"mode": "flat", "samples": 2},
                                                       "cloud": {"color": "classification"}})
    lit = alidade.render(index, camera=camera, samples=2)
    spheres = alidade.render(index, scene={"cloud": {"files": ["elsewhere.las"], "radius": 0.2}, "render": {"samples": 1}},
                             size=(30, 20))
    assert spheres["image"].shape == (20, 30, 3)
    assert flat["image"].shape == (40, 60, 3) and (flat["image"] != lit["image"]).any()
    for arguments, words in (
            (dict(camera={"model": "pinhole"}), "width"), (dict(camera="missing.json"), "missing.json"),
            (dict(layers=["colour"]), "depth.sigma"), (dict(samples=0), "samples"), (dict(size=(0, 5)), "size"),
            (dict(scene={"sun": {"date_time": "2026-06-21T12:00:00Z"}}), "alidade render"),
            (dict(scene={"light": 1}), "light")):
        with pytest.raises(alidade.Error, match=words):
            alidade.render(index, **arguments)


def test_a_camera_that_looks_away_is_a_warning(index):
    camera = {"model": "pinhole", "width": 60, "height": 40, "intrinsics": {"vertical_fov": 40},
              "pose": {"look_at": {"eye": [690000, 5325000, 700], "target": [690001, 5325000, 800]}}}
    with pytest.warns(UserWarning, match="the camera sees nothing"):
        assert not alidade.render(index, camera=camera, samples=1)["alpha"].any()


def test_observers_see_points_and_ground(index):
    seen = alidade.visible(index, [EYE, [690005, 5325010, 601.7]])
    assert seen.shape == (2, len(index)) and seen.dtype == bool
    assert 0.1 < seen[0].mean() < 0.9 and (seen[0] != seen[1]).any()
    assert (alidade.visible(index, EYE) == seen[0]).all()
    near = alidade.visible(index, EYE, max_distance=5)
    assert (np.linalg.norm(index.xyz[near] - EYE, axis=1) <= 5).all() and near.any()
    raster = alidade.viewshed(index, [EYE[:2]], 2.0)
    assert raster.values.shape[0] > 20 and set(np.unique(raster.values[~np.isnan(raster.values)])) <= {-1, 0, 1}
    a, b, left, d, e, top = raster.transform
    assert (a, b, d, e) == (2, 0, 0, -2) and left <= index.bounds[0, 0] and top >= index.bounds[1, 1]
    assert raster.crs == index.crs
    with pytest.raises(alidade.Error, match="no ground"):
        alidade.viewshed(index, [[0, 0]], 2.0)
    with pytest.raises(alidade.Error, match="visible, count"):
        alidade.viewshed(index, [EYE], 2.0, mode="seen")


def test_images_are_compared():
    rng = np.random.default_rng(1)
    a = rng.integers(0, 255, size=(170, 180, 3), dtype=np.uint8)
    same = alidade.compare(a, a)
    assert same.flip == 0 and same.ssim == 1 and same.psnr == np.inf
    other = alidade.compare(a, 255 - a)
    assert other.flip > 0.3 and other.psnr < 12 and other.flip_map.shape == (170, 180)
    linear = alidade.compare(a / 255.0, a / 255.0)
    assert linear.flip == 0
    with pytest.raises(alidade.Error, match="differ in size"):
        alidade.compare(a, a[:-1])
    with pytest.raises(alidade.Error, match="height, width, 3"):
        alidade.compare(a[..., 0], a[..., 0])
