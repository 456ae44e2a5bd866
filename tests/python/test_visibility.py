# SPDX-License-Identifier: MIT
"""Jobs of `alidade visibility`, run from Python."""
import ast
import inspect
import subprocess
from pathlib import Path

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

OBSERVERS = [(689995.0, 5324988.0, 601.7), (690005.0, 5324995.0)]


def test_every_field_of_a_job_is_an_argument_of_its_function():
    stub = ast.parse(Path(alidade.visibility.__file__).with_suffix(".pyi").read_text())
    functions = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    jobs = {name for name, member in inspect.getmembers(alidade.visibility, inspect.isfunction) if not name.startswith("_")}
    assert set(functions) == jobs - {"fill"}
    for name, function in functions.items():
        fields = {field[0] for field in getattr(alidade._alidade, f"_{name}_fields")()}
        own = {"workers", "progress", "note"}
        assert {argument.arg for argument in function.args.kwonlyargs} - own == fields
        for field in fields:
            assert f"\n{field} : " in getattr(alidade.visibility, name).__doc__


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
