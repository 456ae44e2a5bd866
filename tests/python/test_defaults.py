# SPDX-License-Identifier: MIT
"""What is not given is the same for the program, for scene files and for Python: one table for queries, one for surfaces."""
import json
import subprocess
from pathlib import Path

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

# Begins in the midst of the points, so that many are behind it.
RAY = [689990.0, 5324995.0, 601.0, 1.0, 0.4, -0.02]

QUERIES = {
    # name: (options of `alidade query`, the same in Python)
    "first with a radius": (["--ray", "--radius", "0.5", "--k", "1"], lambda index: index.closest(RAY, radius=0.5)),
    "first without": (["--ray", "--k", "1"], lambda index: index.closest(RAY)),
    "all with a radius": (["--ray", "--radius", "0.5"], lambda index: index.within(RAY, radius=0.5)),
    "first few with a radius": (["--ray", "--radius", "0.5", "--k", "7"], lambda index: index.within(RAY, radius=0.5, k=7)),
    "first few without": (["--ray", "--k", "7"], lambda index: index.within(RAY, k=7)),
    "nearest": (["--ray", "--k", "7"], lambda index: index.nearest(RAY, k=7)),
    "nearest with a radius": (["--ray", "--radius", "0.5", "--k", "7", "--measure", "distance"],
                              lambda index: index.nearest(RAY, radius=0.5, k=7)),
    "whole line": (["--line", "--radius", "0.5"], lambda index: index.within(RAY, radius=0.5, t_min=-np.inf)),
    "whole line, nearest": (["--line", "--k", "7"], lambda index: index.nearest(RAY, k=7, t_min=-np.inf)),  # ahead
}


def answers_of_program(cloud, options):
    words = [options[0], ",".join(map(repr, RAY)), *options[1:]]
    return subprocess.run([PROGRAM, "query", cloud, *words, "-q"], check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("name", QUERIES)
def test_queries_have_the_same_defaults(name, yard, index):
    options, ask = QUERIES[name]
    rows = answers_of_program(yard, options).splitlines()[1:]
    expected = [int(row.split(",")[2]) for row in rows]
    assert expected and np.atleast_1d(ask(index).index).tolist() == expected
    behind = any(float(row.split(",")[6]) < 0 for row in rows)
    assert behind == (name == "whole line"), "only a line is asked behind its origin"


def test_counts_and_occlusion_begin_at_the_origin(yard, index):
    back = [*RAY[:3], *np.negative(RAY[3:])]
    ahead, behind, line = (int(index.count(ray, radius=0.5, **more)) for ray, more in
                           ((RAY, {}), (back, {}), (RAY, dict(t_min=-np.inf))))
    assert ahead > 0 and behind > 0 and ahead + behind >= line > max(ahead, behind)
    for option, count in (("--ray", ahead), ("--line", line)):
        assert answers_of_program(yard, [option, "--radius", "0.5", "--count"]).split()[1] == f"0,{count}"
    above = ["0,0", "0,1"]
    up = ",".join(map(repr, [690000.0, 5325000.0, 640.0, 0.0, 0.0, 1.0]))  # the ground is behind
    for option, answer in zip(("--ray", "--line"), above):
        done = subprocess.run([PROGRAM, "query", yard, option, up, "--radius", "1", "--occluded", "-q"], check=True,
                              capture_output=True, text=True)
        assert done.stdout.split()[1] == answer


CAMERA = {"version": 1, "model": "pinhole", "width": 60, "height": 40, "intrinsics": {"vertical_fov": 60},
          "pose": {"look_at": {"eye": [689995, 5324983.5, 601.7], "target": [690000, 5325000, 601]}}}

SURFACES = {
    # name: (options of `alidade render` without a scene, the "cloud" of a scene)
    "nothing": ([], {}),
    "blend": (["--surface", "blend"], {"surface": "blend"}),
    "automatic radius": (["--radius", "auto"], {"radius": "auto"}),
    "adapted radii": (["--radius-factor", "0.8"], {"radius": {"factor": 0.8}}),
    "colour": (["--color-by", "height"], {"color": "height", "material": {"type": "lambertian"}}),
    "sphere": (["--surface", "sphere"], {"surface": "sphere"}),
    "one radius": (["--radius", "0.2"], {"radius": 0.2}),
    "other neighbours": (["--radius-neighbours", "4"], {"radius": {"neighbours": 4}}),
    "hits": (["--hits", "entry"], {"hits": "entry"}),
    "normals": (["--normals", "smooth"], {"normals": "smooth"}),
}
SPHERES = {"sphere", "one radius", "other neighbours", "hits", "normals"}


@pytest.fixture(scope="module")
def depths(yard, index, tmp_path_factory):
    """By name, the depths that the program shows without a scene and with one, and those of Python."""
    folder: Path = tmp_path_factory.mktemp("defaults")
    (folder / "camera.json").write_text(json.dumps(CAMERA))

    def of_program(*words):
        subprocess.run([PROGRAM, "render", *words, "--depth", folder / "d.npy", "--overwrite", "-q"], check=True)
        return np.load(folder / "d.npy")

    def all_three(options, cloud):
        scene = {"version": 1, "cloud": {"file": str(yard), **cloud}, "camera": CAMERA}
        (folder / "scene.json").write_text(json.dumps(scene))
        depth = alidade.render(index, camera=CAMERA, scene={"cloud": cloud}, samples=1, layers=["depth"])["depth"]
        return [of_program(yard, "--camera", folder / "camera.json", *options), of_program(folder / "scene.json"),
                np.where(np.isfinite(depth), depth, 0)]

    return {name: all_three(*row) for name, row in SURFACES.items()}


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_have_the_same_defaults(name, depths):
    alone, scene, python = depths[name]
    assert (alone > 0).mean() > 0.3
    assert (alone == scene).all() and (alone == python).all()
    like = "sphere" if name in ("hits", "normals") else "blend" if name in ("nothing", "automatic radius", "colour") else name
    assert (alone == depths[like][0]).all()
    assert (np.median(alone) < np.median(depths["blend"][0])) == (name in SPHERES), "spheres are nearer by their radius"
