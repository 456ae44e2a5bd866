# SPDX-License-Identifier: MIT
"""Jobs of `alidade visibility`, run from Python."""
import csv
import subprocess

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

OBSERVERS = [(689995.0, 5324988.0, 601.7), (690005.0, 5324995.0)]


def test_a_map_is_that_of_the_program(yard, tmp_path):
    notes = []
    fields = dict(observer=OBSERVERS, mode="count", resolution=2, max_distance=np.float64(40), extent=(689985, 5324985, 690015, 5325015))
    answer = alidade.visibility.raster(yard, output=tmp_path / "python.tif", note=notes.append, **fields)
    subprocess.run([PROGRAM, "visibility", "raster", yard, "--observer", "689995,5324988,601.7", "--observer", "690005,5324995", "--mode", "count",
        "--resolution", "2", "--max-distance", "40", "--extent", "689985,5324985,690015,5325015", "-o", tmp_path / "program.tif", "-q"], check=True)
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(tmp_path / "python.tif") as python, rasterio.open(tmp_path / "program.tif") as program:
        assert np.array_equal(python.read(1), program.read(1))
        assert np.array_equal(answer.values, program.read(1))
        assert tuple(program.transform)[:6] == answer.transform and program.nodata == answer.nodata
        own, others = python.tags(), program.tags()
        del own["alidade_command"], others["alidade_command"]
        assert own == others and answer.metadata["alidade_observer_count"] == "2"
    assert answer.values.dtype == np.uint16 and any(text.startswith("sight: ") for text in notes)
    assert answer.metadata["alidade_command"].startswith("alidade visibility raster yard.las --resolution 2 --extent ")


def test_nothing_is_written_without_an_output(yard, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = alidade.visibility.raster(yard, observer=OBSERVERS[1], resolution=4)
    assert answer.values.dtype == np.uint8 and set(np.unique(answer.values)) <= {0, 254, 255}
    assert list(tmp_path.iterdir()) == []


def test_wrong_fields_are_errors(yard):
    for fields, text in [(dict(observr=OBSERVERS), "unknown field 'observr' of visibility raster; did you mean 'observer'"),
                         (dict(observer=OBSERVERS, mode="all"), "mode: invalid value; expected visible|count"),
                         (dict(observer=OBSERVERS, resolution=(1, 2)), "resolution: invalid value"),
                         (dict(observer=OBSERVERS, curvature=1, refraction_coeff=0), "refraction_coeff excludes"),
                         (dict(), "missing observers")]:
        with pytest.raises(alidade.Error, match=text.replace("|", r"\|")):
            alidade.visibility.raster(yard, **fields)


def test_messages_name_fields(yard, tmp_path):
    for fields, text in [(dict(), "missing observers; expected observer, observers or observer_grid"),
                         (dict(observer=OBSERVERS, mode="height", highest=1, target_height=2), "highest does not exceed target_height")]:
        with pytest.raises(alidade.Error, match=text):
            alidade.visibility.raster(yard, **fields)


def test_clouds_are_selected_by_fields(yard):
    seen = alidade.visibility.points(files=yard, observer=OBSERVERS[0], crop=(689990, 5324980, 690000, 5324990), ignore_classes=[])
    some = alidade.visibility.points(yard, observer=OBSERVERS[0], classes=[2], where="x < 690000", partial=True)
    cloud = alidade.open(yard)
    x, y = cloud.xyz[:, 0], cloud.xyz[:, 1]
    assert len(seen.columns["Visible"]) == ((x >= 689990) & (x <= 690000) & (y >= 5324980) & (y <= 5324990)).sum()
    assert len(some.columns["Visible"]) == ((cloud["classification"] == 2) & (x < 690000)).sum()
    with pytest.raises(alidade.Error, match="where: "):
        alidade.visibility.points(yard, observer=OBSERVERS[0], where="x <")
    with pytest.raises(alidade.Error, match="missing files"):
        alidade.visibility.points(observer=OBSERVERS[0])
    with pytest.raises(TypeError, match="1 positional argument"):
        alidade.visibility.points(yard, yard)


def test_flags_are_bools_of_numpy_too(yard):
    far = (700000, 5324988, 610)
    with pytest.raises(alidade.Error, match="anywhere accepts it"):
        alidade.visibility.points(yard, observer=far, anywhere=np.False_)
    assert not alidade.visibility.points(yard, observer=far, anywhere=np.True_, max_distance=1).columns["Visible"].any()


def test_points_have_the_columns_of_the_file(yard, tmp_path):
    answer = alidade.visibility.points(yard, observer=OBSERVERS, output=tmp_path / "seen.las", fraction=4)
    written = alidade.open(tmp_path / "seen.las")
    assert set(answer.columns) == {"Visible", "VisibleCount", "VisibleBy", "VisibleFraction"}
    for name, values in answer.columns.items():
        assert np.array_equal(values, written[name]) and values.dtype == written[name].dtype
    assert answer.rows["name"].tolist() == ["observer 1", "observer 2"] and answer.rows["x"].tolist() == [689995, 690005]
    sight = alidade.visible(alidade.open(yard).index(), [OBSERVERS[0]], height=0)
    alone = alidade.visibility.points(yard, observer=OBSERVERS[0], ignore_classes="none")
    assert np.array_equal(alone.columns["Visible"].astype(bool), sight[0]) and "Blocker" in alone.columns


def rows_of(file):
    with open(file, newline="") as lines:
        return list(csv.DictReader(lines))


@pytest.mark.parametrize("job, fields", [
    ("summary", dict(observer=OBSERVERS)),
    ("horizon", dict(observer=OBSERVERS[0], step=10)),
    ("sun", dict(observer=OBSERVERS, from_="2026-06-21", step=60, place=(48, 11))),
])
def test_rows_are_those_of_the_file(job, fields, yard, tmp_path):
    answer = getattr(alidade.visibility, job)(yard, output=tmp_path / "rows.csv", **fields)
    rows = rows_of(tmp_path / "rows.csv")
    assert rows and list(answer.columns) == list(rows[0])
    for name, values in answer.columns.items():
        assert len(values) == len(rows)
        if values.dtype.kind == "U":
            assert values.tolist() == [row[name] for row in rows]
        elif name != "point_id":
            assert np.allclose(values, [float(row[name] or "nan") for row in rows], equal_nan=True, rtol=1e-4, atol=1e-4)


def test_lines_are_rows_of_every_kind(yard, tmp_path):
    (tmp_path / "ends.csv").write_text("name,x,y,z\nroof,690000,5325021,613.5\nyard,690010,5324985,601.7\nhall,690005,5324995,601.7\n")
    answer = alidade.visibility.lines(yard, places=tmp_path / "ends.csv")
    columns = answer.columns
    assert columns["from"].tolist() == ["roof", "roof", "yard"] and columns["visible"].dtype == bool
    assert columns["line"].dtype == np.int64 and np.isnan(columns["blocker_at"][columns["visible"]]).all()


def test_sky_and_sun_are_points_or_maps(yard):
    sky = alidade.visibility.sky(yard, directions=8)
    ground = alidade.visibility.sky(yard, directions=8, resolution=4)
    assert sky.columns["SkyView"].shape == (len(alidade.open(yard)),) and ground.values.ndim == 2
    day = dict(from_="2026-06-21", step=120, place=(48, 11))
    maps = alidade.visibility.sun(yard, resolution=4, **day)
    hours = maps["SunHours"]
    assert hours.values.shape == ground.values.shape and hours.values.max() > 1 and hours.nodata == -9999
    assert alidade.visibility.sun(yard, **day).columns["SunHours"].shape == sky.columns["SkyView"].shape


def test_notes_before_an_error_are_heard(yard):
    notes = []
    with pytest.raises(alidade.Error, match="no observer reaches the map"):
        alidade.visibility.raster(yard, observer=(700000, 5324988, 610), anywhere=True, max_distance=50, note=notes.append)
    assert any(text.startswith("ground: ") for text in notes)


def test_progress_can_end_the_work(yard):
    def stop(done, total):
        raise RuntimeError("enough")
    with pytest.raises(RuntimeError, match="enough"):
        alidade.visibility.raster(yard, observer=OBSERVERS, progress=stop)
