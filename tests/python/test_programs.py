# SPDX-License-Identifier: MIT
"""Threads, processes, Ctrl-C, progress, and the manual."""
import importlib.util
import inspect
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import alidade
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).parents[2]


def test_sixteen_threads_share_an_index(scattered, rays):
    expected = scattered.closest(rays, radius=0.3).index
    with ThreadPoolExecutor(16) as pool:
        for found in pool.map(lambda _: scattered.closest(rays, radius=0.3).index, range(64)):
            assert (found == expected).all()


def test_an_index_outlives_its_cloud(rays):
    cloud = alidade.Cloud(np.random.default_rng(2).uniform(size=(1000, 3)), intensity=np.arange(1000))
    index = cloud.index()
    column = index["intensity"]
    del cloud
    assert index.nearest_points(index.xyz).index[:, 0].tolist() == list(range(1000))
    del index
    assert column[999] == 999


def test_a_forked_process_reads_the_cloud():
    code = ("import alidade, os, numpy as np\n"
            "cloud = alidade.Cloud(np.eye(3))\n"
            "child = os.fork()\n"
            "if child == 0: os._exit(0 if cloud.xyz.shape == (3, 3) else 1)\n"
            "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0\n")
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


@pytest.mark.parametrize("work", [lambda index: alidade.render(index, samples=100_000),
                                  lambda index: index.count(np.tile([689950, 5325000, 600, 1, 0, 0.0], (10**6, 1)),
                                                            radius=50),
                                  lambda index: index.closest(np.tile([689950, 5325000, 600, 1, 0, 0.0], (10**6, 1)),
                                                              radius=50, where=np.zeros(len(index.xyz), bool)),
                                  lambda index: index.nearest_points(np.tile([689950, 5325000, 600.0], (10**6, 1)),
                                                                     where=np.zeros(len(index.xyz), bool))])
def test_control_c_ends_work_of_hours(index, work):
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        work(index)
    timer.join()
    assert time.monotonic() - begin < 60


def test_progress_is_told_and_can_end_the_work(index):
    calls = []
    alidade.render(index, size=(60, 40), samples=2, progress=lambda done, total: calls.append((done, total)))
    assert calls and all(0 <= done <= total for done, total in calls)

    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        alidade.render(index, samples=1000, progress=stop)


def test_everything_public_has_a_manual_and_a_stub():
    stub = (pathlib.Path(alidade.__file__).parent / "__init__.pyi").read_text()
    for owner in (alidade, alidade.Cloud, alidade.Index):
        for name, member in vars(owner).items():
            if name.startswith("_") or inspect.ismodule(member):
                continue
            assert member.__doc__, name
            assert re.search(rf"\b(def|class|as) {name}\b", stub), name
            is_job = owner is alidade and hasattr(alidade.jobs, name)  # test_jobs.py
            if callable(member) and not inspect.isclass(member) and not is_job:
                names = list(inspect.signature(member).parameters)
                text = re.search(rf"def {name}\((.*?)\) ->", stub, re.S).group(1)
                stubs = [word for word in re.findall(r"(\w+)\s*[:=]", re.sub(r"\[[^\[\]]*\]|\"[^\"]*\"", "", text))
                         if word != "self"]
                assert [word for word in stubs if word in names] == names, (name, stubs, names)


@pytest.mark.parametrize("page", ["docs/python.md", "docs/python_from_others.md"])
def test_the_code_of_pages_runs(page, yard, tmp_path, monkeypatch):
    text = (ROOT / page).read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) > 3
    monkeypatch.chdir(tmp_path)
    (tmp_path / "output").mkdir()
    (tmp_path / "output/courtyard.las").symlink_to(yard)
    names, absent = {}, set()
    for block in blocks:
        modules = [name for names in re.findall(r"^import (\w+)|^from (\w+)", block, re.M) for name in names if name]
        absent |= {name for name in modules if importlib.util.find_spec(name) is None}
        # plt is what matplotlib is called.
        if any(re.search(rf"\b{name}\b", block) for name in absent) or ("matplotlib" in absent and "plt." in block):
            warnings.warn(f"a block of {page} was left out: no {', '.join(sorted(absent))}")
            continue
        exec(compile(block, page, "exec"), names)
