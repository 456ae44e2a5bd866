# SPDX-License-Identifier: MIT
"""Clouds on a web server, in this process."""
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import alidade
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "remote"))
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


def test_an_index_file_is_queried_where_it_lies(server, index_file):
    server.forget()
    far, near = alidade.open(server.address("good", index_file.name)), alidade.open(index_file)
    assert server.sent < 0.5 * index_file.stat().st_size
    rays = [[690000, 5325000, 640, 0.01 * i, 0, -1] for i in range(50)]
    np.testing.assert_array_equal(far.closest(rays, radius=0.3).index, near.closest(rays, radius=0.3).index)
    for name in near.keys():
        np.testing.assert_array_equal(far[name], near[name])
    np.testing.assert_array_equal(far.xyz, near.xyz)


def test_a_network_that_fails_is_an_error(server, index_file):
    server.forget()
    far = alidade.open(server.address("gone-3", index_file.name))
    with pytest.raises(alidade.Error, match="cannot read from the server"):
        far["gps_time"]
    with pytest.raises(alidade.Error, match="cannot read from the server"):
        far.closest([[690000, 5325000, 640, 0, 0, -1]], radius=0.3)
    with pytest.raises(alidade.Error, match="HTTP status 404"):
        alidade.open(server.address("good", "missing.laz"))


def test_a_cloud_that_failed_stays_failed_and_others_do_not(server, yard, index_file, tmp_path):
    server.forget()
    # Not the URL above, of which blocks are in memory.
    far = alidade.open(server.address("gone-03", index_file.name))
    for _ in range(2):
        with pytest.raises(alidade.Error, match="cannot read from the server"):
            far["gps_time"]
    for name in ("far.alidade", "far.las"):
        save = far.save if name.endswith("alidade") else far.write
        with pytest.raises(alidade.Error, match="cannot read from the server"):
            save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    near = alidade.open(index_file)
    again = alidade.open(server.address("good", index_file.name))
    for cloud in (near, again):
        assert len(cloud["classification"]) == len(cloud.xyz)
        cloud.closest([[690000, 5325000, 640, 0, 0, -1]], radius=0.3)
    del far, save
    again.save(tmp_path / "again.alidade")


def test_columns_stay_what_they_were(server, index_file):
    far, near = alidade.open(server.address("good", index_file.name)), alidade.open(index_file)
    columns = {name: far[name] for name in far.keys()}
    server.forget()
    for name, values in columns.items():
        np.testing.assert_array_equal(values, near[name])
    assert server.requests == 0


def test_a_process_that_forks_has_to_open_again(server, index_file):
    far = alidade.open(server.address("good", index_file.name))
    expected = alidade.open(index_file)["gps_time"]
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        problems = []
        for read in (lambda: far["gps_time"], lambda: far.closest([[690000, 5325000, 640, 0, 0, -1]], radius=0.3)):
            try:
                read()
            except alidade.Error as error:
                problems.append("forked" in str(error))
        del far, read
        os._exit(0 if problems == [True, True] else 1)
    assert os.waitpid(child, 0)[1] == 0
    before = time.process_time()
    time.sleep(0.3)
    assert time.process_time() - before < 0.2  # threads that spin take all of it
    np.testing.assert_array_equal(far["gps_time"], expected)


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


@pytest.mark.parametrize("answered, script", [
    (0, "alidade.open(ADDRESS)"), (3, "alidade.open(ADDRESS).xyz"),
    (3, "alidade.open(ADDRESS).closest([[690000, 5325000, 640, 0, 0, -1]], radius=0.3)")])
def test_ctrl_c_ends_the_wait_for_a_server(server, index_file, answered, script):
    server.forget()
    address = server.address(f"silent-{answered}", index_file.name)
    with subprocess.Popen([sys.executable, "-c", f"import alidade; ADDRESS = {address!r}\n{script}"],
                          stderr=subprocess.PIPE) as program:
        while server.requests <= answered and program.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        program.send_signal(signal.SIGINT)
        message = program.communicate(timeout=20)[1]
    assert b"KeyboardInterrupt" in message, message


def test_an_interruption_is_no_error_without_one(server, index_file):
    server.forget()
    address = server.address("silent-3", index_file.name)
    script = f"""
import alidade, signal
far = alidade.open({address!r})
for _ in range(2):
    try:
        far.xyz
    except KeyboardInterrupt:
        print("interrupted", flush=True)
    except alidade.Error as error:
        print(error, flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as program:
        while server.requests <= 3 and program.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        program.send_signal(signal.SIGINT)
        said = program.communicate(timeout=20)[0]
    assert said == ("interrupted\nthe wait for a server was interrupted; expected the cloud, opened again\n")
