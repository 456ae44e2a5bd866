# SPDX-License-Identifier: MIT
"""The query job, run from Python."""
import csv
import subprocess

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

EYE = [689995.0, 5324988.0, 601.7]


@pytest.fixture(scope="module")
def looks():
    """Rays from an eye in all directions."""
    azimuth = np.radians(np.arange(0, 360, 7.5))
    directions = np.stack([np.sin(azimuth), np.cos(azimuth), np.full_like(azimuth, 0.05)], axis=1)
    return np.hstack([np.tile(EYE, (len(azimuth), 1)), directions])


def test_answers_are_those_of_the_index(yard, index, looks):
    found = alidade.jobs.query(yard, ray=looks, radius=0.2)
    lists = index.within(looks, radius=0.2)
    assert found.columns["ray_id"].tolist() == np.repeat(np.arange(len(looks)), np.diff(lists.offsets)).tolist()
    for name, expected in (("point_id", lists.index), ("t", lists.t), ("distance", lists.distance), ("entry", lists.entry)):
        assert np.array_equal(found.columns[name], expected), name
    assert np.array_equal(np.stack([found.columns[axis] for axis in "xyz"], axis=1), index.xyz[lists.index])
    assert found.crs == index.crs and found.facts == {}
    counts = alidade.jobs.query(yard, rays=looks.reshape(6, 8, 6), radius=0.2, count=True, classes=[2])
    assert np.array_equal(counts.columns["count"], index.count(looks, radius=0.2, classes=[2]))
    assert alidade.jobs.query(yard, ray=looks, radius=0.2, occluded=True).columns["occluded"].max() == 1


def test_answers_are_those_of_the_program(yard, looks, tmp_path):
    np.savetxt(tmp_path / "rays.csv", looks, fmt="%.17g", delimiter=",", header="ox,oy,oz,dx,dy,dz", comments="")
    run = subprocess.run([PROGRAM, "query", yard, "--rays", tmp_path / "rays.csv", "--radius", "0.2", "--k", "2", "-q"],
                         check=True, capture_output=True, text=True)
    rows = list(csv.DictReader(run.stdout.splitlines()))
    found = alidade.jobs.query(yard, rays=tmp_path / "rays.csv", radius=0.2, k=2)
    assert list(found.columns) == list(rows[0]) and len(rows) > 10
    for name, values in found.columns.items():
        assert np.allclose(values, [float(row[name]) for row in rows], rtol=0, atol=1e-3), name
        assert values.dtype == (np.int64 if name in ("ray_id", "rank", "point_id") else np.float64)
    for output in ("python.csv", "python.las"):
        written = alidade.jobs.query(yard, rays=tmp_path / "rays.csv", radius=0.2, k=2, output=tmp_path / output)
        assert written.columns == {}
    assert (tmp_path / "python.csv").read_text() == run.stdout
    assert len(alidade.open(tmp_path / "python.las")) == len(rows)


def test_all_kinds_of_targets_are_arrays(yard, index):
    x, y, z = EYE
    low, high = np.array(EYE) - 3, np.array(EYE) + 3
    box = alidade.jobs.query(yard, box=np.concatenate([low, high]))
    assert sorted(box.columns["point_id"]) == sorted(index.in_box([*low, *high]).index)
    for fields in (dict(boxes=[[*low, *high]]), dict(box="689992,5324985,598.7,689998,5324991,604.7")):
        assert len(alidade.jobs.query(yard, **fields).columns["point_id"]) == len(box.columns["point_id"])
    # The optional columns: an interval of the ray, a radius of the cone, numbers of paths and regions.
    near = alidade.jobs.query(yard, rays=[(x, y, z, 0, 1, 0, 0, 5), (x, y, z, 0, 1, 0, 0, np.nan)], radius=2.5)
    assert near.columns["t"][near.columns["ray_id"] == 0].max() <= 5 < near.columns["t"].max()
    assert len(alidade.jobs.query(yard, cones=[(x, y, z, 0, 1, 0, 10)]).columns["cone_id"]) > 0
    assert set(alidade.jobs.query(yard, line=(x, y, z, 0, 1, 0), radius=0.5).columns["ray_id"]) == {0}
    path = alidade.jobs.query(yard, path=[(x, y, z, 4), (x + 5, y, z, 4), (x, y, z, 7), (x, y + 5, z, 7)], radius=2)
    assert set(path.columns["path_id"]) == {4, 7} and "segment" in path.columns
    assert len(alidade.jobs.query(yard, planes=[(x, y, z, 1, 0, 0), (x, y, z, 0, 1, 0)]).columns["region_id"]) > 0
    points = alidade.jobs.query(yard, points=[EYE, high], k=3, explain=True)
    assert points.columns["rank"].tolist() == [0, 1, 2, 0, 1, 2] and points.facts["points"] == 2


def test_arrays_of_any_layout_and_type_are_targets(yard, looks):
    def found(rays):
        return alidade.jobs.query(yard, rays=rays, radius=0.2).columns
    expected = found(looks)
    assert len(expected["t"]) > 10
    spread, frozen = np.zeros((2 * len(looks), 18)), looks.copy()
    spread[::2, ::3] = looks
    frozen.flags.writeable = False
    for rays in (spread[::2, ::3], frozen, np.asfortranarray(looks), looks[::-1][::-1], looks.astype(">f8"), looks.astype(np.longdouble),
                 looks.tolist(), list(looks)):
        answers = found(rays)
        assert all(np.array_equal(answers[name], expected[name]) for name in expected)
    pandas = pytest.importorskip("pandas")
    assert np.array_equal(found(pandas.DataFrame(looks, columns=["ox", "oy", "oz", "dx", "dy", "dz"]))["t"], expected["t"])


def test_no_targets_have_no_answers(yard, tmp_path):
    nothing = np.empty((0, 6))
    none = alidade.jobs.query(yard, rays=nothing, radius=0.2, explain=True)
    assert list(none.columns)[:3] == ["ray_id", "rank", "point_id"] and none.facts["rays"] == 0
    assert all(len(values) == 0 for values in none.columns.values())
    assert alidade.jobs.query(yard, lines=nothing, count=True).columns["count"].dtype == np.int64
    assert len(alidade.jobs.query(yard, path=np.empty((0, 3))).columns["path_id"]) == 0
    alidade.jobs.query(yard, rays=nothing, output=tmp_path / "none.csv")
    assert (tmp_path / "none.csv").read_text() == "ray_id,rank,point_id,x,y,z,t,distance,entry\n"


def test_wrong_targets_are_errors(yard, looks):
    for fields, text in [(dict(), "missing targets"), (dict(rays=looks[:, :5]), "rays has the wrong shape; expected rows of ox,oy,oz"),
                         (dict(ray=looks, rays="rays.csv"), "exclude each other"), (dict(ray=looks, rays=looks), "targets given twice"),
                         (dict(rays=looks, boxes=[[0, 0, 0, 1, 1, 1]]), "different kinds of targets"),
                         (dict(ray=looks * [1, 1, 1, 0, 0, 0]), "row 0"), (dict(rays=[["a"] * 6]), "rays is not an array of real numbers"), (dict(rays="missing.csv"), "missing.csv"),
                         (dict(rays=looks + 0j), "rays is not an array of real numbers; .*found dtype complex128"),
                         (dict(rays=looks > 0), "rays is not an array of real numbers"), (dict(rays=[(0, 0, 0, 1, 0, 0), (1,)]), "rays is not an array"),
                         (dict(rays={1.0, 2.0}), "rays is not an array of real numbers"), (dict(rays=np.empty((0, 5))), "rays has the wrong shape"),
                         (dict(ray=[]), "missing targets"), (dict(rays=looks + np.inf), "row 0: ox out of range"),
                         (dict(points=np.zeros((2, 3)) + [[0], [np.nan]]), "points: row 1: missing value of x"),
                         (dict(ray=["0,0,0,1,0,0", "0,0,0"]), "not a ray")]:
        with pytest.raises(alidade.Error, match=text):
            alidade.jobs.query(yard, **fields)
