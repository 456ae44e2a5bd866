# SPDX-License-Identifier: MIT
"""Every command of the program that is a job is a function, and every option of it a keyword."""
import inspect
import re
import signal
import subprocess
import sys

import alidade
import numpy as np
import pytest
import stubs
from alidade._jobs import _FIELDS, function_name, keyword
from conftest import PROGRAM

# Commands about the program itself.
OF_THE_PROGRAM = {"formats", "manual"}
# Options of the command line itself: threads are `workers`, messages are `note` and warnings, and answers are arrays.
OF_THE_COMMAND_LINE = {"help", "threads", "quiet", "verbose", "json", "csv", "explain", "idiff_codes", "dry_run"}


def help_of(*words):
    return subprocess.run([PROGRAM, *words, "--help"], check=True, capture_output=True, text=True).stdout


def commands_of(*words):
    """The commands that the help of a group lists, with their groups."""
    text = help_of(*words)
    if "\nCommands:\n" not in text:
        return [" ".join(words)] if words else []
    listed = text.split("\nCommands:\n")[1].split("\n\n")[0]
    names = re.findall(r"^  ([a-z][a-z-]*)", listed, re.MULTILINE)
    is_group_only = words and "[COMMAND]" not in text.split("Usage: ")[1].split("\n")[0]
    own = [] if not words or is_group_only else [" ".join(words)]
    return own + [command for name in names for command in commands_of(*words, name)]


def function_of(command):
    module = alidade.visibility if command.startswith("visibility ") else alidade.jobs
    return getattr(module, function_name(command))


def test_every_command_is_a_function():
    commands = set(commands_of())
    assert {"visibility raster", "convert", "query", "sql load"} <= commands
    assert commands - OF_THE_PROGRAM == set(_FIELDS)


@pytest.mark.parametrize("command", sorted(_FIELDS))
def test_every_option_is_a_keyword(command):
    function = function_of(command)
    parameters = inspect.signature(function).parameters
    options = re.findall(r"^  (-[^ ]+)", help_of(*command.split()).split("\nForm:")[0], re.MULTILINE)
    assert len(options) > 3
    for option in options:
        names = {name.lstrip("-").replace("-", "_") for name in option.split(",")}
        names |= {name + "_" for name in names}  # from_
        assert names & (set(parameters) | OF_THE_COMMAND_LINE), f"{option} of {command}"
    for field in _FIELDS[command]:
        assert f"\n{keyword(field)} : " in function.__doc__
    assert set(parameters) == {keyword(field) for field in _FIELDS[command]} | {"workers", "progress", "note"}


@pytest.mark.parametrize("command", sorted(_FIELDS))
def test_every_field_is_known(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for field in _FIELDS[command]:
        # Nothing else is given, so the job is mostly rejected, but not because of this keyword.
        try:
            # A cache is for the process, and made where the next tests run.
            other = str(tmp_path / "cache") if field[0] == "cache" else "?"
            function_of(command)(**{keyword(field): True if field[3] == "flag" else other})
        except alidade.Error as error:
            assert "unknown field" not in str(error)


def test_stubs_are_those_of_the_fields():
    if not {"cache", "memory"} <= {field[0] for field in _FIELDS["info"]}:
        pytest.skip("the stubs have the options of the extensions web and scratch")
    for file, commands in stubs.stubs().items():
        assert file.read_text() == stubs.stub_text(file, commands), "run tests/python/stubs.py"


def test_clouds_are_described_and_written(tmp_path):
    cloud = alidade.jobs.generate("courtyard", points=2e4)
    assert isinstance(cloud, alidade.Cloud) and len(cloud) == 20000
    assert alidade.jobs.generate("courtyard", points=2e4, output=tmp_path / "site.las") is None
    assert np.array_equal(alidade.open(tmp_path / "site.las").xyz, cloud.xyz)
    with pytest.raises(alidade.Error, match="missing output"):
        alidade.jobs.convert(tmp_path / "site.las")
    done = alidade.jobs.convert(tmp_path / "site.las", output=tmp_path / "ground.laz", classes=2)
    assert done["points"] == (cloud["classification"] == 2).sum() and len(alidade.open(tmp_path / "ground.laz")) == done["points"]
    assert alidade.jobs.index(tmp_path / "site.las", output=tmp_path / "site.alidade")["points"] == len(alidade.open(tmp_path / "site.alidade"))
    assert alidade.jobs.info(tmp_path / "site.las")["points"] == len(cloud)
    assert alidade.jobs.catalog(tmp_path, output=tmp_path / "all.catalog.json")["files"] == 2


def test_images_are_compared_by_file(yard, tmp_path):
    for seed in (1, 2):
        subprocess.run([PROGRAM, "render", yard, "--size", "60x40", "--samples", "1", "--seed", str(seed), "-o", tmp_path / f"{seed}.png", "-q"],
                       check=True)
    answer = alidade.jobs.compare(tmp_path / "1.png", tmp_path / "2.png", fail_above="flip=0")
    assert answer["metrics"]["flip"]["mean"] > 0 and answer["pass"] is False


def test_statements_return_columns(yard, tmp_path):
    rows = alidade.jobs.sql(yard, "SELECT classification AS class, count(*) AS points, max(z) AS top FROM points GROUP BY 1 ORDER BY 1")
    cloud = alidade.open(yard)
    assert rows.columns["points"].sum() == len(cloud) and rows.columns["class"].tolist() == sorted(set(cloud["classification"].tolist()))
    assert rows.columns["top"].max() == pytest.approx(cloud.xyz[:, 2].max())
    with pytest.raises(alidade.Error, match="missing statement"):
        alidade.jobs.sql(yard)
    assert alidade.jobs.sql_load([yard, tmp_path / "yard.db"])["points"] == len(cloud)
    counts = alidade.jobs.sql(tmp_path / "yard.db", "SELECT count(*) FROM points; SELECT :name AS word", param="name=wall")
    assert [next(iter(one.columns.values())).tolist() for one in counts] == [[len(cloud)], ["wall"]]


def test_columns_keep_every_value(yard):
    def column(statement):
        return next(iter(alidade.jobs.sql(yard, statement).columns.values()))
    assert column("SELECT 1 UNION ALL SELECT 'a' UNION ALL SELECT NULL UNION ALL SELECT 2.5").tolist() == [1, "a", None, 2.5]
    assert column("SELECT 9223372036854775807 UNION ALL SELECT NULL").tolist() == [9223372036854775807, None]
    assert column("SELECT x'ff00'").tolist() == [b"\xff\x00"]
    assert column("SELECT 'a' || char(0)").tolist() == ["a\0"]
    assert np.array_equal(column("SELECT 1 UNION ALL SELECT NULL"), [1, np.nan], equal_nan=True)
    assert column("SELECT 'a' UNION ALL SELECT NULL").tolist() == ["a", ""]
    assert column("SELECT x FROM points LIMIT 0").dtype == float
    same = alidade.jobs.sql(yard, "SELECT 1 AS x, 2 AS x, 3 AS x").columns
    assert {name: values.tolist() for name, values in same.items()} == {"x": [1], "x:1": [2], "x:2": [3]}


@pytest.mark.parametrize("fields, error, message", [
    (dict(max_distance=True), TypeError, "max_distance: expected LENGTH, found bool"),
    (dict(max_distance={}), TypeError, "max_distance: expected a number, a text, or a sequence of them, found dict"),
    (dict(max_distance=np.complex128(5 + 2j)), TypeError, "max_distance: expected a number, a text, or a sequence of them, found complex128"),
    (dict(max_distance=np.array(5j)), TypeError, "found ndarray"),
    (dict(max_distance=5j), TypeError, "found complex"),
    (dict(max_distance=np.timedelta64(5, "s")), TypeError, "found timedelta64"),
    (dict(observer=np.array([1, 2, 3j])), TypeError, "observer: expected a number, a text, or a sequence of them, found complex128"),
    (dict(observer=np.zeros((1, 1, 3))), TypeError, "observer: expected a number, a text, or a sequence of them, found ndarray"),
    (dict(observer=(1, None, 3)), TypeError, "found NoneType"),
    (dict(observer=(one for one in (1, 2, 3))), TypeError, "found generator"),
    (dict(partial=1), TypeError, "partial: expected True or False, found int"),
    (dict(output=("a.las", "b.las")), alidade.Error, "output: expected one value, found 2"),
    (dict(output="a.las\0b"), alidade.Error, "output: invalid value; expected a text without bytes of value 0"),
    (dict(crop=[]), alidade.Error, "crop: missing value"),
    (dict(nothing=None), alidade.Error, "unknown field 'nothing'"),
    (dict(max_distanc=1), alidade.Error, "did you mean 'max_distance'?"),
    (dict(workers="2"), TypeError, "'str' object cannot be interpreted as an integer"),
    (dict(progress=5), TypeError, "progress: expected a function, found int"),
    (dict(note="x"), TypeError, "note: expected a function, found str"),
    (dict(files="site--output.las"), alidade.Error, "site--output.las: cannot open"),
    (dict(files=[]), alidade.Error, "files: expected at least 1 value, found 0"),
    (dict(files={"a": 1}), TypeError, "files: expected a name, or a list of names, found dict"),
    (dict(files="a.las\0b"), alidade.Error, "files: invalid value")])
def test_wrong_values_are_named(yard, fields, error, message):
    with pytest.raises(error) as raised:
        alidade.visibility.points(**{"files": yard, "observer": (689995, 5324983.5, 601.7), **fields})
    assert message in str(raised.value)


def test_clouds_are_files(yard, index):
    with pytest.raises(TypeError, match="files: expected a name, or a list of names, found Index"):
        alidade.visibility.points(index)
    with pytest.raises(TypeError, match="files: expected a name, or a list of names, found Index"):
        alidade.open(index)


def test_values_have_any_type_of_numbers(yard):
    def points(**fields):
        return alidade.visibility.points(yard, observer=np.array([689995, 5324983.5, 601.7], dtype=object), **fields).columns["VisibleCount"]
    expected = points(max_distance=20, classes="2,6", partial=True)
    for distance in (np.float32(20), np.array(20), np.uint8(20), "20", [20]):
        for classes in ({2, 6}, np.array([2, 6], dtype=np.uint8), (2.0, 6), b"2,6"):
            assert np.array_equal(points(max_distance=distance, classes=classes, partial=np.True_, workers=np.int64(2**40)), expected)


def test_a_job_of_another_thread_ends_with_ctrl_c(yard):
    script = f"""
import alidade, threading
ended = threading.Event()
def work():
    try:
        alidade.visibility.sky({str(yard)!r}, directions=4096, progress=lambda done, total: print(flush=True))
    except alidade.Error as error:
        print(error)
    ended.set()
threading.Thread(target=work).start()
try:
    ended.wait()
except KeyboardInterrupt:
    ended.wait()
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as program:
        program.stdout.readline()
        program.send_signal(signal.SIGINT)
        said = program.communicate(timeout=60)[0]
    assert said.split("\n")[-2] == "the work was interrupted by Ctrl-C before its end"
