# SPDX-License-Identifier: MIT
"""Every command of the program that is a job is a function, and every option of it a keyword."""
import inspect
import re
import subprocess

import alidade
import numpy as np
import pytest
import stubs
from alidade._jobs import _FIELDS, function_name, keyword
from conftest import PROGRAM

# Commands that Python cannot run yet. Whoever makes one a job removes it here.
NO_JOBS = {"query", "render", "merge"}
# Commands about the program itself.
OF_THE_PROGRAM = {"formats", "manual"}
# Options of the command line itself: threads are `workers`, messages are `note` and warnings, and answers are arrays.
OF_THE_COMMAND_LINE = {"help", "threads", "quiet", "verbose", "json", "csv", "explain", "idiff_codes"}


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
    assert {"visibility raster", "change", "query", "sql load"} <= commands
    assert commands - OF_THE_PROGRAM - NO_JOBS == set(_FIELDS)
    assert NO_JOBS <= commands


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


def test_stubs_are_those_of_the_fields():
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
