# SPDX-License-Identifier: MIT
"""Jobs that render, run from Python."""
import json
import re
import subprocess

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

SMALL = dict(size=(48, 32), samples=2)


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """A mesh in front of the courtyard's overview."""
    file = tmp_path_factory.mktemp("wall") / "wall.obj"
    file.write_text("v 689990 5324990 600\nv 690010 5324990 600\nv 690010 5324990 609\nv 689990 5324990 609\nf 1 2 3\nf 1 3 4\n")
    return file


def only(rendering):
    assert len(rendering.images) == 1
    return rendering.images[0]


def test_images_are_those_of_the_program(yard, tmp_path):
    answer = alidade.jobs.render(yard, output=tmp_path / "python.png", seed=3, color_by="classification", **SMALL)
    subprocess.run([PROGRAM, "render", yard, "--seed", "3", "--color-by", "classification", "--size", "48x32", "--samples", "2",
                    "-o", tmp_path / "program.png", "-q"], check=True)
    compared = alidade.jobs.compare(tmp_path / "python.png", tmp_path / "program.png")
    assert compared["metrics"]["flip"]["mean"] == 0
    image = only(answer)
    assert image.layers == {} and image.file == str(tmp_path / "python.png") and answer.files == [image.file]
    assert image.statistics["most_samples"] == 2 and image.statistics["rays"] > 48 * 32
    assert answer.empty_views == [] and answer.crs == alidade.open(yard).crs


def test_images_are_arrays_without_an_output(yard, index, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    notes = []
    image = only(alidade.jobs.render(yard, layers=["color", "depth", "depth.sigma"], note=notes.append, **SMALL))
    assert set(image.layers) == {"image", "color", "alpha", "depth", "depth.sigma"} and image.file is None
    assert image.layers["image"].shape == (32, 48, 3) and image.layers["depth"].shape == (32, 48)
    assert list(tmp_path.iterdir()) == [] and any("rays in" in text for text in notes)
    same = alidade.render(index, size=(48, 32), samples=2, layers=["color", "depth"])
    assert np.array_equal(np.isinf(image.layers["depth"]), np.isinf(same["depth"]))
    # The camera that was chosen gives the same view again.
    again = alidade.render(index, camera=image.camera, samples=2, layers=["depth"])
    assert np.array_equal(again["depth"], same["depth"])


def test_meshes_light_and_colours(yard, wall):
    plain = only(alidade.jobs.render(yard, **SMALL)).layers["image"]
    notes = []
    with_wall = alidade.jobs.render(yard, mesh=wall, note=notes.append, **SMALL)
    assert any("2 triangles from " in text for text in notes)
    pictures = [only(with_wall).layers["image"]]
    pictures.append(only(alidade.jobs.render(yard, sun_time="2026-06-21T06:00:00+02:00", note=notes.append, **SMALL)).layers["image"])
    assert any("sun at azimuth" in text for text in notes)
    pictures.append(only(alidade.jobs.render(yard, sun=(200, 30), no_sun=False, exposure=1, **SMALL)).layers["image"])
    for fields in (dict(mode="headlight"), dict(mode="flat", color_by="height", color_map="viridis"), dict(mode="ambient_occlusion", ao_distance=2),
                   dict(surface="sphere", radius=0.3), dict(color_by="classification", class_color="2=#ff0000")):
        pictures.append(only(alidade.jobs.render([yard], **fields, **SMALL)).layers["image"])
    assert all((picture != plain).any() for picture in pictures)
    alone = only(alidade.jobs.render(mesh=[wall], layers="depth", **SMALL)).layers["depth"]
    assert np.isfinite(alone).any() and np.isinf(alone).any()


def test_a_sky_from_an_image(yard, tmp_path):
    done = alidade.jobs.render(yard, panorama=(690000, 5325000, 602), size=(64, 32), samples=1, output=tmp_path / "sky.exr")
    scene = {"version": 1, "sky": {"type": "image", "file": "sky.exr"}, "output": {"file": "scene.png"},
             "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"type": "lambertian", "albedo": [0.5, 0.5, 0.5]}}],
             "camera": {"version": 1, "model": "pinhole", "width": 8, "height": 6, "intrinsics": {"vertical_fov": 60},
                        "pose": {"look_at": {"eye": [0, -5, 1], "target": [0, 0, 0], "up": [0, 0, 1]}}}}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    notes = []
    image = only(alidade.jobs.render(tmp_path / "scene.json", note=notes.append))
    assert image.layers["image"].shape == (6, 8, 3) and any("sky.exr, 64 x 32 pixels" in text for text in notes)
    assert only(done).name == "" and {file.name for file in tmp_path.iterdir()} == {"sky.exr", "scene.json"}


def test_rasters_depth_maps_and_legends_are_files(yard, tmp_path):
    answer = alidade.jobs.render(yard, orthographic="top", resolution=1, layers=["color", "elevation"], samples=1, color_by="height",
                                 legend=tmp_path / "legend.png", output=tmp_path / "site.tif")
    assert {re.sub(".*/", "", file) for file in answer.files} == {"site.tif", "site_elevation.tif", "legend.png"}
    answer = alidade.jobs.render(yard, depth=tmp_path / "depth.tif", **SMALL)
    assert answer.images == [] and answer.files == [str(tmp_path / "depth.tif")]


def test_parts_are_merged(yard, tmp_path):
    parts = [alidade.jobs.render(yard, part=(number, 2), output=tmp_path / "image.png", **SMALL).files[0] for number in (1, 2)]
    merged = alidade.jobs.merge(parts)
    whole = only(alidade.jobs.render(yard, **SMALL)).layers
    assert all(np.array_equal(merged.layers[name], whole[name]) for name in ("image", "color", "alpha"))
    assert merged.file is None and merged.camera is None and merged.statistics["parts"] == 2
    written = alidade.jobs.merge(parts, output=tmp_path / "image.png")
    assert written.layers == {} and written.file == str(tmp_path / "image.png") and (tmp_path / "image.png").exists()
    with pytest.raises(alidade.Error, match="missing output"):
        alidade.jobs.render(yard, part="1/2", **SMALL)


def test_a_stopped_render_resumes(yard, tmp_path):
    class Enough(Exception):
        pass

    def stop(done, total):
        if total == 48 * 32 * 400 and 3 * done > total:
            raise Enough

    fields = dict(size=(48, 32), samples=400, checkpoint=tmp_path / "image.checkpoint")
    with pytest.raises(Enough):
        alidade.jobs.render(yard, progress=stop, **fields)
    assert (tmp_path / "image.checkpoint").exists()
    notes = []
    image = only(alidade.jobs.render(yard, resume=True, note=notes.append, **fields))
    assert any("resuming from " in text for text in notes) and not (tmp_path / "image.checkpoint").exists()
    whole = only(alidade.jobs.render(yard, size=(48, 32), samples=400))
    assert np.array_equal(image.layers["color"], whole.layers["color"])


def test_a_view_of_nothing_is_named(yard, tmp_path):
    camera = {"version": 1, "model": "pinhole", "width": 60, "height": 40, "intrinsics": {"vertical_fov": 40},
              "pose": {"look_at": {"eye": [690000, 5325000, 700], "target": [690001, 5325000, 800]}}}
    (tmp_path / "up.json").write_text(json.dumps(camera))
    with pytest.warns(UserWarning, match="sees nothing"):
        answer = alidade.jobs.render(yard, camera=tmp_path / "up.json", samples=1)
    assert len(answer.empty_views) == 1 and not only(answer).layers["alpha"].any()


def test_wrong_fields_are_errors(yard):
    for fields, text in [(dict(size=(0, 5)), "size: invalid value"), (dict(layers="colour"), "layers: unknown layer"),
                         (dict(mode="flat", sun=(1, 2)), "sun does not apply to this mode"),
                         (dict(layers="elevation"), "layers of the ground require an orthophoto")]:
        with pytest.raises(alidade.Error, match=text):
            alidade.jobs.render(yard, **fields)
    for fields, text in [(dict(scene="a.json"), "files is given twice"), (dict(color="height", color_by="rgb"), "color_by is given twice")]:
        with pytest.raises(TypeError, match=text):
            alidade.jobs.render(yard, **fields)
    with pytest.raises(alidade.Error, match="nothing to render"):
        alidade.jobs.render()
