# SPDX-License-Identifier: MIT
"""Clouds on a web server, in this process."""
import sys
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
