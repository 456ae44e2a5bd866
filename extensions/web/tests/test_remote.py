# SPDX-License-Identifier: MIT
"""Clouds on a web server, in this process."""
import signal
import subprocess
import sys
import time
from pathlib import Path

import alidade
import numpy as np
import pytest

from conftest import index, yard  # noqa: F401, fixtures

sys.path.insert(0, str(Path(__file__).parent))
import range_server


@pytest.fixture(scope="module")
def server(yard):
    try:
        server = range_server.RangeServer(str(yard.parent))
    except OSError as error:
        pytest.skip(f"no server on the loopback interface: {error}")
    yield server
    server.shutdown()


@pytest.fixture(scope="module")
def index_file(yard, index) -> Path:
    file = yard.with_suffix(".alidade")
    index.save(file, overwrite=True)
    return file


def test_a_cloud_is_read_from_the_web(server, yard):
    far, near = alidade.open(server.address("good", yard.name)), alidade.open(yard)
    np.testing.assert_array_equal(far.xyz, near.xyz)
    np.testing.assert_array_equal(far["classification"], near["classification"])


def test_an_index_file_is_fetched_and_queried(server, index_file):
    server.forget()
    told = []
    far = alidade.open(server.address("good", index_file.name), progress=lambda done, all: told.append((done, all)))
    near = alidade.open(index_file)
    size = index_file.stat().st_size
    assert size <= server.sent < 1.1 * size + 100_000
    assert (size, size) in told
    rays = [[690000, 5325000, 640, 0.01 * i, 0, -1] for i in range(50)]
    np.testing.assert_array_equal(far.closest(rays, radius=0.3).index, near.closest(rays, radius=0.3).index)
    for name in near.keys():
        np.testing.assert_array_equal(far[name], near[name])
    np.testing.assert_array_equal(far.xyz, near.xyz)


def test_a_network_that_fails_is_an_error(server, index_file):
    server.forget()
    alidade.open(server.address("good", index_file.name + "?count"))
    for answered in range(server.requests):
        server.forget()
        with pytest.raises(alidade.Error, match="cannot read from the server"):
            alidade.open(server.address(f"gone-{answered}", index_file.name))
    with pytest.raises(alidade.Error, match="HTTP status 404"):
        alidade.open(server.address("good", "missing.laz"))


def test_columns_stay_what_they_were(server, index_file):
    far, near = alidade.open(server.address("good", index_file.name)), alidade.open(index_file)
    columns = {name: far[name] for name in far.keys()}
    server.forget()
    for name, values in columns.items():
        np.testing.assert_array_equal(values, near[name])
    assert server.requests == 0


def test_processes_that_fork_keep_apart_what_servers_without_ranges_send(server, yard, index_file):
    # Each in a process of its own: what is read depends on what was opened before.
    script = f"""
import alidade, os
alidade.open({server.address("plain", index_file.name)!r})  # begins the temporary file
opened, go_on = os.pipe(), os.pipe()
child = os.fork()
if child == 0:
    try:
        far = alidade.open({server.address("plain", index_file.name + "?again")!r})
        os.write(opened[1], b"x")
        os.read(go_on[0], 1)
        near = alidade.open({str(index_file)!r})
        os._exit(0 if all((far[name] == near[name]).all() for name in near.keys()) else 1)
    finally:
        os._exit(1)
os.close(opened[1])
assert os.read(opened[0], 1) == b"x"
alidade.open({server.address("plain", yard.name)!r})
os.write(go_on[1], b"x")
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


@pytest.mark.parametrize("is_fetching", [False, True])
def test_ctrl_c_ends_the_wait_for_a_server(server, index_file, is_fetching):
    server.forget()
    alidade.open(server.address("good", f"{index_file.name}?{is_fetching}"))
    answered = server.requests - 1 if is_fetching else 0
    server.forget()
    address = server.address(f"silent-{answered}", index_file.name)
    with subprocess.Popen([sys.executable, "-c", f"import alidade; alidade.open({address!r})"],
                          stderr=subprocess.PIPE) as program:
        while server.requests <= answered and program.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        program.send_signal(signal.SIGINT)
        begin = time.monotonic()
        message = program.communicate(timeout=20)[1]
    assert b"KeyboardInterrupt" in message, message
    assert time.monotonic() - begin < 5


def test_an_index_file_that_becomes_shorter_ends_the_process(index_file, tmp_path):
    file = tmp_path / "cut.alidade"
    file.write_bytes(index_file.read_bytes())
    script = f"import alidade, os; cloud = alidade.open({str(file)!r}); os.truncate({str(file)!r}, 8192); print(cloud.xyz.sum())"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, b"")
    assert b"alidade: error: " in done.stderr
    assert b"cut.alidade: the file became shorter" in done.stderr
