#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# test_wheel.sh WHEEL: installs a wheel into an environment of its own, which takes NumPy alone from the system, and tries it there.
set -euo pipefail
wheel=$(readlink -f -- "$1")
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
/usr/bin/python3 -m venv --system-site-packages "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet --no-index --no-deps "$wheel"
cd "$scratch"
env -u PYTHONPATH "$scratch/venv/bin/python" - <<'END'
import pathlib
import subprocess
import sys

import alidade
import numpy as np

folder = pathlib.Path(alidade.__file__).parent
assert folder.is_relative_to(sys.prefix), folder
linked = subprocess.run(["ldd", next(folder.glob("_alidade*.so"))], check=True, capture_output=True, text=True).stdout
for name in ("libtbb", "libfmt", "libpugixml"):
    line = next(line for line in linked.splitlines() if name in line)
    assert str(folder) in line, line
assert "gdal" not in linked and "OpenImageIO" not in linked, linked
xyz = np.random.default_rng(1).uniform([0, 0, 0], [20, 20, 0.02], size=(20000, 3))
alidade.Cloud(xyz, intensity=np.arange(20000)).write("flat.laz")
index = alidade.open("flat.laz").index()
assert index.nearest_points(index.xyz[:9]).index[:, 0].tolist() == list(range(9))
assert index.occluded([10, 10, 5, 0, 0, -1], radius=0.5)
assert alidade.render(index, size=(40, 30), samples=1)["image"].shape == (30, 40, 3)
print(f"the wheel works: alidade {alidade.__version__}, {sum(file.stat().st_size for file in folder.iterdir()) / 1e6:.1f} MB")
END
