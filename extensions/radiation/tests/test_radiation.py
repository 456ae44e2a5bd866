# SPDX-License-Identifier: MIT
import alidade
import numpy as np
from conftest import yard  # noqa: F401, a fixture


def test_energies_stand_behind_hours(yard):
    day = dict(from_="2026-06-21", step=120, place=(48, 11))
    assert list(alidade.visibility.sun(yard, resolution=4, beam_only=True, **day)) == ["SunHours", "BeamEnergy"]
    rows = alidade.visibility.sun(yard, observer=(689995, 5324988, 601.7), turbidity=5, **day).columns
    assert np.allclose(rows["GlobalEnergy"], rows["BeamEnergy"] + rows["DiffuseEnergy"] + rows["ReflectedEnergy"])
