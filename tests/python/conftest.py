# SPDX-License-Identifier: MIT
import os
import subprocess
from pathlib import Path

import alidade
import numpy as np
import pytest

PROGRAM = os.environ.get("ALIDADE_PROGRAM", "alidade")


@pytest.fixture(scope="session")
def yard(tmp_path_factory) -> Path:
    """A LAS file of 100,000 points of a simulated courtyard."""
    file = tmp_path_factory.mktemp("yard") / "yard.las"
    subprocess.run([PROGRAM, "generate", "courtyard", "--points", "1e5", "-o", file, "-q"], check=True)
    return file


@pytest.fixture(scope="session")
def index(yard) -> alidade.Index:
    return alidade.open(yard).index(surfaces=True)


@pytest.fixture(scope="session")
def scattered() -> alidade.Index:
    """2000 points in a box of 10 by 10 by 2 metres, in classes 0 to 4."""
    rng = np.random.default_rng(7)
    xyz = rng.uniform([0, 0, 0], [10, 10, 2], size=(2000, 3))
    return alidade.Cloud(xyz, classification=np.arange(2000) % 5, scale=1e-6).index()


@pytest.fixture(scope="session")
def rays() -> np.ndarray:
    rng = np.random.default_rng(8)
    origins = rng.uniform([-2, -2, -2], [12, 12, 4], size=(500, 3))
    targets = rng.uniform([0, 0, 0], [10, 10, 2], size=(500, 3))
    return np.hstack([origins, targets - origins])
