# SPDX-License-Identifier: MIT
import os

import alidade
import numpy as np
import pytest

XYZ = np.array([[690000.25, 5325000.5, 600.125], [690001.0, 5325002.0, 603.0], [690004.5, 5325001.0, 601.0]])


def test_arrays_become_a_cloud_and_come_back():
    cloud = alidade.Cloud(XYZ, intensity=[1, 2, 65535], classification=np.array([2, 2, 6], np.int64),
                          color=np.array([[255, 0, 1]] * 3, np.uint8), gps_time=[0.5, 1.5, 2.5],
                          return_number=[1, 2, 3], number_of_returns=[3, 3, 3], normal=np.eye(3),
                          Reflectance=np.array([-1.5, 0.0, 2.5], np.float32), crs="EPSG:25832")
    np.testing.assert_allclose(cloud.xyz, XYZ, atol=1e-6, rtol=0)
    assert len(cloud) == 3 and "25832" in cloud.crs
    assert cloud["intensity"].dtype == np.uint16 and cloud["intensity"].tolist() == [1, 2, 65535]
    assert cloud["color"].tolist() == [[65535, 0, 257]] * 3
    assert cloud["return_number"].tolist() == [1, 2, 3] and cloud["number_of_returns"].tolist() == [3, 3, 3]
    assert cloud["normal"].tolist() == np.eye(3).tolist()
    assert cloud["Reflectance"].tolist() == [-1.5, 0.0, 2.5]
    assert "Reflectance" in cloud and "user_data" not in cloud
    np.testing.assert_allclose(cloud.bounds, [XYZ.min(0), XYZ.max(0)], atol=1e-6, rtol=0)


def test_columns_share_the_clouds_memory_and_are_read_only():
    cloud = alidade.Cloud(XYZ, intensity=[1, 2, 3], return_number=[1, 2, 3])
    for name in ("intensity", "return_number"):
        assert np.shares_memory(cloud[name], cloud[name])
        assert not cloud[name].flags.writeable
    assert cloud.xyz is cloud.xyz and not cloud.xyz.flags.writeable
    column = cloud["intensity"]
    del cloud
    assert column.tolist() == [1, 2, 3]


def test_what_numpy_converts_is_converted():
    expected = alidade.Cloud(XYZ, scale=0.001).xyz
    for other in (XYZ.tolist(), np.asfortranarray(XYZ), np.repeat(XYZ, 2, axis=0)[::2], XYZ.astype(np.longdouble),
                  XYZ.astype(">f8")):
        assert alidade.Cloud(other, scale=0.001).xyz.tolist() == expected.tolist()
    values = np.array([1.5, -2.5, 1e300])
    for other in (values.astype(">f8"), np.repeat(values, 2)[::2]):
        assert alidade.Cloud(XYZ, a=other)["a"].tolist() == values.tolist()
    assert alidade.Cloud(XYZ, a=np.array([1, -2, 3], ">i2"))["a"].tolist() == [1, -2, 3]


def test_values_that_are_marked_as_none_are_nan(tmp_path):
    """A LAS file whose extra dimensions have marks: a scaled int16 and a plain uint8."""
    cloud = alidade.Cloud(XYZ, a=np.array([-32768, 150, 2], np.int16), b=np.array([255, 0, 7], np.uint8))
    cloud.write(tmp_path / "marked.las")
    bytes_ = bytearray((tmp_path / "marked.las").read_bytes())
    for name, scale, mark in ((b"a", 0.01, np.int64(-32768)), (b"b", None, np.uint64(255))):
        entry = bytes_.index(name.ljust(32, b"\0")) - 4
        bytes_[entry + 3] |= 1 | (8 if scale else 0)
        bytes_[entry + 40:entry + 48] = mark.tobytes()
        bytes_[entry + 112:entry + 120] = np.float64(scale or 0).tobytes()
    (tmp_path / "marked.las").write_bytes(bytes_)
    marked = alidade.open(tmp_path / "marked.las")
    marked.index().save(tmp_path / "marked.alidade")
    for there in (marked, alidade.open(tmp_path / "marked.alidade")):
        np.testing.assert_array_equal(there["a"], [np.nan, 1.5, 0.02])
        np.testing.assert_array_equal(there["b"], [np.nan, 0, 7])
        assert not there["b"].flags.writeable


def test_long_names_are_warned_of(tmp_path):
    cloud = alidade.Cloud(XYZ, **{"C2C_absolute_distances[0.05]_max_" + axis: [1, 2, 3] for axis in "XY"})
    with pytest.warns(UserWarning, match="LAS keeps 32 bytes of the names"):
        cloud.write(tmp_path / "long.las")
    assert len(set(alidade.open(tmp_path / "long.las").keys()) - {"intensity"}) >= 2


def test_colours_of_8_bits_come_out_of_an_index_as_16(tmp_path):
    cloud = alidade.Cloud(XYZ, color=np.array([[255, 0, 1], [2, 3, 4], [5, 6, 7]], np.uint8))
    cloud.index().save(tmp_path / "site.alidade")
    color = alidade.open(tmp_path / "site.alidade")["color"]
    assert color.dtype == np.uint16 and not color.flags.writeable
    assert color.tolist() == cloud["color"].tolist()


def test_codes_of_epsg_say_what_they_are_themselves():
    """Geographic and projected systems alike, whatever their numbers."""
    for code, word in ((4326, "GEOGCS"), (4647, "PROJCS"), (7844, "GEOGCS"), (25832, "PROJCS")):
        assert alidade.Cloud(XYZ, crs=f"EPSG:{code}").crs.startswith(word)
    with pytest.raises(alidade.Error, match="EPSG:999999"):
        alidade.Cloud(XYZ, crs="EPSG:999999")


def test_names_that_are_not_utf_8_are_found():
    cloud = alidade.Cloud(XYZ, **{"Höhe": [1.0, 2.0, 3.0]})
    assert cloud.keys() == ["Höhe"] and cloud["Höhe"].tolist() == [1, 2, 3]


def test_scaled_dimensions_are_doubles(yard):
    cloud = alidade.open(yard)
    assert all(cloud[name].flags.writeable is False for name in cloud.keys())


@pytest.mark.parametrize("arguments, words", [
    (dict(xyz=XYZ[:, :2]), ["(..., 3)", "(3, 2)", "float64"]),
    (dict(xyz=XYZ[0]), ["(n, 3)", "(3,)"]),
    (dict(xyz=XYZ.astype(complex)), ["real numbers", "complex128"]),
    (dict(xyz="points"), ["shape"]),
    (dict(xyz=[[0, 0, np.nan]]), ["row 0", "finite"]),
    (dict(xyz=[[0, 0, 0], [0, 0, np.inf]]), ["row 1", "finite"]),
    (dict(xyz=[[0, 0, 0], [1e9, 0, 0]], scale=0.001), ["row 1", "larger scale"]),
    (dict(xyz=XYZ, scale=-1), ["scale"]),
    (dict(xyz=XYZ, intensity=[1, 2]), ["intensity", "(3,)", "(2,)"]),
    (dict(xyz=XYZ, intensity=[1, 2, 65536]), ["intensity", "uint16"]),
    (dict(xyz=XYZ, classification=[1, 2, 2.5]), ["classification", "uint8"]),
    (dict(xyz=XYZ, color=[1, 2, 3]), ["color", "(3, 3)"]),
    (dict(xyz=XYZ, Name=np.array(["a", "b", "c"])), ["Name", "<U1"]),
    (dict(xyz=XYZ, crs="EPSG:none"), ["EPSG:n"]),
])
def test_wrong_arrays_are_errors_that_name_them(arguments, words):
    with pytest.raises(alidade.Error) as error:
        alidade.Cloud(**arguments)
    for word in words:
        assert word in str(error.value)
    assert isinstance(error.value, ValueError)


def test_files_are_written_and_opened(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cloud = alidade.Cloud(XYZ, intensity=[1, 2, 3], Reflectance=np.array([1, 2, 3], np.int16), scale=0.001,
                          crs="EPSG:25832")
    for name in ("site.las", "site.laz", "site.ply", "site.copc.laz"):
        cloud.write(tmp_path / name)
        again = alidade.open(tmp_path / name)
        # COPC has an order of its own.
        order = np.argsort(again["intensity"])
        np.testing.assert_allclose(again.xyz[order], cloud.xyz, atol=1e-9, rtol=0)
        assert again["intensity"][order].tolist() == [1, 2, 3]
        with pytest.raises(alidade.Error, match="exists"):
            cloud.write(tmp_path / name)
        cloud.write(tmp_path / name, overwrite=True)
    assert alidade.open(str(tmp_path / "site.laz")).crs == cloud.crs
    assert len(alidade.open([tmp_path / "site.las", tmp_path / "site.laz"])) == 6
    assert len(alidade.open(tmp_path / "site.la?")) == 6
    cloud.index().save(tmp_path / "site.alidade")
    mapped = alidade.open("site.alidade")
    assert isinstance(mapped, alidade.Index) and mapped.xyz.tolist() == cloud.xyz.tolist()
    assert mapped["Reflectance"].tolist() == [1, 2, 3]
    monkeypatch.chdir(tmp_path.parent)
    mapped.write(tmp_path / "again.las")
    mapped.save(tmp_path / "again.alidade")
    assert (tmp_path / "again.alidade").stat().st_size == (tmp_path / "site.alidade").stat().st_size
    with pytest.raises(alidade.Error, match="another organisation"):
        mapped.index(organisation="layered")
    assert alidade.open(tmp_path / "again.las").xyz.tolist() == cloud.xyz.tolist()


def test_files_that_are_not_there_or_no_clouds_are_errors(tmp_path):
    with pytest.raises(alidade.Error, match="missing.las"):
        alidade.open(tmp_path / "missing.las")
    (tmp_path / "broken.las").write_bytes(b"LASF" + bytes(100))
    with pytest.raises(alidade.Error, match="broken.las"):
        alidade.open(tmp_path / "broken.las")
    with pytest.raises(alidade.Error, match="format"):
        alidade.Cloud(XYZ).write(tmp_path / "site.txt")
    with pytest.raises(TypeError):
        alidade.open(17)


def test_missing_attributes_are_key_errors():
    with pytest.raises(KeyError, match="intensity"):
        alidade.Cloud(XYZ, intensity=[1, 2, 3])["color"]


def test_empty_clouds_have_empty_answers():
    index = alidade.Cloud(np.empty((0, 3))).index()
    assert len(index) == 0 and index.xyz.shape == (0, 3)
    assert index.closest([0, 0, 0, 0, 0, 1], radius=1).index == -1
    assert index.in_box([0, 0, 0, 1, 1, 1]).index.size == 0
    with pytest.raises(alidade.Error, match="no points"):
        alidade.render(index)


def test_an_index_that_is_cut_below_python_is_an_error(scattered, rays, tmp_path):
    scattered.save(tmp_path / "cut.alidade")
    mapped = alidade.open(tmp_path / "cut.alidade")
    assert (mapped.closest(rays, radius=0.05).index >= 0).any()
    os.truncate(tmp_path / "cut.alidade", 4096)
    for use in (lambda: mapped.closest(rays, radius=0.05), lambda: mapped.nearest(rays, k=3), lambda: mapped.xyz,
                lambda: mapped.write(tmp_path / "again.las")):
        with pytest.raises(alidade.Error, match="cut.alidade: the file changed or its disk failed while it was read"):
            use()
    assert not (tmp_path / "again.las").exists()
    del mapped
    scattered.save(tmp_path / "next.alidade")
