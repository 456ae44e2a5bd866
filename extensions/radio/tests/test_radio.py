# SPDX-License-Identifier: MIT
import alidade
import numpy as np
from conftest import yard  # noqa: F401, a fixture


def test_a_frequency_adds_columns(yard, tmp_path):
    (tmp_path / "ends.csv").write_text("name,x,y,z\nroof,690000,5325021,613.5\nyard,690010,5324985,601.7\n")
    columns = alidade.visibility.lines(yard, places=tmp_path / "ends.csv", frequency="5.8GHz").columns
    assert columns["visible"].dtype == bool and np.isfinite(columns["fresnel_radius"]).all()
