# SPDX-License-Identifier: MIT
import json

import alidade
from conftest import yard  # noqa: F401, a fixture


def test_photos_are_points_and_rows_of_photos(yard, tmp_path):
    camera = {"version": 1, "model": "pinhole", "width": 60, "height": 40, "intrinsics": {"vertical_fov": 60},
              "pose": {"look_at": {"eye": [689995, 5324983.5, 601.7], "target": [690000, 5325000, 601]}}}
    (tmp_path / "one.camera.json").write_text(json.dumps(camera))
    answer = alidade.visibility.photos(yard, camera=tmp_path / "one.camera.json")
    assert answer.columns["PhotoCount"].sum() == answer.rows["points"].sum() > 0
    assert list(tmp_path.iterdir()) == [tmp_path / "one.camera.json"]
