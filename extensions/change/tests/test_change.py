# SPDX-License-Identifier: MIT
import subprocess

import alidade
import numpy as np
from conftest import PROGRAM, yard  # noqa: F401, a fixture


def test_changes_are_of_both_epochs(yard, tmp_path):
    later = tmp_path / "later.las"
    subprocess.run([PROGRAM, "generate", "courtyard", "--points", "5e4", "--seed", "2", "-o", later, "-q"], check=True)
    answer = alidade.change(yard, later, no_sight=True)
    for epoch, file in ((answer.before, yard), (answer.after, later)):
        assert len(epoch.columns["Change"]) == len(alidade.open(file)) == epoch.rows["count"].sum()
        assert epoch.rows["class"].tolist()[:2] == ["same", "moved"]
        assert np.bincount(epoch.columns["Change"], minlength=8).tolist() == epoch.rows["count"].tolist()
