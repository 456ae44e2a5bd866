# SPDX-License-Identifier: MIT
import os
import struct
import subprocess
import sys

import alidade
import numpy as np
import pytest
from conftest import PROGRAM

XYZ = np.array([[690000.25, 5325000.5, 600.125], [690001.0, 5325002.0, 603.0], [690004.5, 5325001.0, 601.0]])

# Metres in plan, heights in US survey feet.
PLANE = ('PROJCS["Oregon",GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,298.257222101]],'
         'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic_2SP"],'
         'PARAMETER["latitude_of_origin",41.75],PARAMETER["central_meridian",-120.5],PARAMETER["standard_parallel_1",43],'
         'PARAMETER["standard_parallel_2",45.5],PARAMETER["false_easting",400000],PARAMETER["false_northing",0],'
         'UNIT["metre",1]]')
FEET = (f'COMPD_CS["both",{PLANE},VERT_CS["NAVD88 height (ftUS)",VERT_DATUM["North American Vertical Datum 1988",2005],'
        'UNIT["US survey foot",0.304800609601219],AXIS["Up",UP]]]')


def las_file(crs: str | list, steps: list) -> bytes:
    """LAS 1.4, point format 6, positions in steps of 0.01; WKT or GeoTIFF keys."""
    is_wkt = isinstance(crs, str)
    text = crs.encode() + b"\0" if is_wkt else struct.pack(f"<{len(crs)}H", *crs)
    header = struct.pack("<4sHH16sBB32s32sHHHIIBHI20s12d", b"LASF", 0, 16 * is_wkt, b"", 1, 4, b"", b"", 1, 2026, 375,
                         375 + 54 + len(text), 1, 6, 30, 0, b"", .01, .01, .01, 0, 0, 0, 1e6, 0, 1e6, 0, 1e6, 0)
    header += struct.pack("<QQIQ15Q", 0, 0, 0, len(steps), len(steps), *[0] * 14)
    record = struct.pack("<H16sHH32s", 0, b"LASF_Projection", 2112 if is_wkt else 34735, len(text), b"") + text
    return header + record + b"".join(struct.pack("<3i18x", *step) for step in steps)


def test_heights_in_another_unit_are_converted_with_a_warning(tmp_path):
    (tmp_path / "feet.las").write_bytes(las_file(FEET, [[100, 100, 1000], [200, 100, 2000]]))
    with pytest.warns(UserWarning, match="heights are converted from US survey foot to metre"):
        cloud = alidade.open(tmp_path / "feet.las")
    np.testing.assert_allclose(cloud.xyz[:, 2], np.array([10, 20]) * 1200 / 3937, rtol=1e-12)
    assert 'VERT_CS["NAVD88 height"' in cloud.crs and "foot" not in cloud.crs
    assert alidade.Cloud(cloud.xyz, crs=cloud.crs, scale=0.001).crs == cloud.crs
    subprocess.run([PROGRAM, "convert", tmp_path / "feet.las", "-o", tmp_path / "feet.alidade", "-q"], check=True)
    with pytest.raises(alidade.Error, match="an index of heights that are not in the unit of x and y"):
        alidade.open(tmp_path / "feet.alidade")


def test_codes_of_geotiff_keys_are_those_of_plan_and_heights(tmp_path):
    plan, heights = [3072, 0, 1, 25832], [4096, 0, 1, 7837]
    for keys, crs in ((plan, "EPSG:25832"), (plan + heights, "EPSG:25832+7837")):
        (tmp_path / "keys.las").write_bytes(las_file([1, 1, 0, len(keys) // 4, *keys], [[100, 100, 1000]]))
        assert alidade.open(tmp_path / "keys.las").crs == crs


def test_files_of_different_systems_are_an_error_however_they_are_written(tmp_path):
    step = [[100, 100, 1000]]
    (tmp_path / "a.las").write_bytes(las_file(PLANE, step))
    (tmp_path / "b.las").write_bytes(las_file(PLANE.replace('UNIT["metre",1]', 'UNIT["foot",0.3048]'), step))
    (tmp_path / "c.las").write_bytes(las_file(PLANE.replace("Oregon", "oregon lcc"), step))
    with pytest.raises(alidade.Error, match="the coordinate reference system differs"):
        alidade.open([tmp_path / "a.las", tmp_path / "b.las"])
    assert len(alidade.open([tmp_path / "a.las", tmp_path / "c.las"])) == 2


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
    (dict(xyz=XYZ, crs=FEET), ["heights in another unit than x and y"]),
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


@pytest.mark.parametrize("use", ["mapped.closest(rays, radius=0.05)", "mapped.nearest(rays, k=3)", "mapped.xyz.sum()",
                                 "mapped.write('again.las')"])
def test_an_index_that_is_cut_below_python_ends_it_with_an_error(use, scattered, rays, tmp_path):
    scattered.save(tmp_path / "cut.alidade")
    np.save(tmp_path / "rays.npy", rays)
    program = ("import os, alidade, numpy as np\nmapped, rays = alidade.open('cut.alidade'), np.load('rays.npy')\n"
               f"os.truncate('cut.alidade', 4096)\n{use}\nprint('went on')\n")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == ""
    assert "cut.alidade: the file became shorter, or its disk failed, while it was in use" in done.stderr
    assert not (tmp_path / "again.las").exists()
