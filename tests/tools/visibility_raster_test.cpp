// SPDX-License-Identifier: MIT
#include <gdal.h>

#include <array>
#include <fstream>
#include <map>

#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

/// A wall, 3 high, between two patches of ground, 20 x 20 in all.
PointCloud garden(const std::string& wkt) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  for (int x = 0; x <= 80; ++x) {
    for (int y = 0; y <= 80; ++y) cloud.positions.emplace_back(250 * x, 250 * y, 0);
  }
  for (int y = 0; y <= 80; ++y) {
    for (int z = 1; z <= 12; ++z) cloud.positions.emplace_back(10000, 250 * y, 250 * z);
  }
  for (const LatticePosition& position : cloud.positions)
    cloud.classifications.push_back(position.z > 0 ? 6 : 2);
  cloud.crs.wkt = wkt;
  return cloud;
}

const std::string k_metres = R"(LOCAL_CS["garden",UNIT["metre",1]])";

/// What GDAL reads of a map of one band.
struct ReadMap {
  int columns = 0, rows = 0;
  GDALDataType type = GDT_Unknown;
  std::array<double, 6> transform{};
  double no_data = 0.0;
  std::map<std::string, std::string> metadata;
  std::vector<double> values;

  double at(int column, int row) const { return values[static_cast<std::size_t>(row * columns + column)]; }
};

class VisibilityRasterTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    GDALAllRegister();
    write_las(folder / "garden.las", garden(k_metres));
  }

  ReadMap read_map(const std::string& name) const {
    ReadMap map;
    const GDALDatasetH file = GDALOpen((folder / name).c_str(), GA_ReadOnly);
    if (file == nullptr) {
      ADD_FAILURE() << name << " is no map";
      return map;
    }
    map.columns = GDALGetRasterXSize(file);
    map.rows = GDALGetRasterYSize(file);
    GDALGetGeoTransform(file, map.transform.data());
    const GDALRasterBandH band = GDALGetRasterBand(file, 1);
    map.type = GDALGetRasterDataType(band);
    map.no_data = GDALGetRasterNoDataValue(band, nullptr);
    for (char** item = GDALGetMetadata(file, nullptr); item != nullptr && *item != nullptr; ++item) {
      const std::string text = *item;
      map.metadata[text.substr(0, text.find('='))] = text.substr(text.find('=') + 1);
    }
    map.values.resize(static_cast<std::size_t>(map.columns * map.rows));
    EXPECT_EQ(GDALRasterIO(band, GF_Read, 0, 0, map.columns, map.rows, map.values.data(), map.columns,
                           map.rows, GDT_Float64, 0, 0),
              CE_None);
    GDALClose(file);
    return map;
  }
  ProgramResult raster(const Words& more) {
    Words words = {"visibility", "raster", "garden.las"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  /// Expects the command to fail with this in its message, and to leave no map.
  void expect_rejected(const Words& more, const std::string& message) {
    const ProgramResult result = raster(more);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_TRUE(contains(result.err, message)) << result.err;
    EXPECT_FALSE(contains(result.err, "discs block")) << "surfaces were measured before: " << message;
    EXPECT_FALSE(std::filesystem::exists(folder / "seen.tif")) << message;
  }
};

const Words k_eye = {"--observer", "690005,5325010,601.7", "--resolution", "1", "-o", "seen.tif"};

TEST_F(VisibilityRasterTest, the_map_lies_on_the_cloud_and_ends_at_the_wall) {
  const ProgramResult result = raster(k_eye);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const ReadMap map = read_map("seen.tif");
  EXPECT_EQ(map.columns, 20);
  EXPECT_EQ(map.rows, 20);
  EXPECT_EQ(map.transform, (std::array<double, 6>{690000, 1, 0, 5325020, 0, -1}));
  EXPECT_EQ(map.type, GDT_Byte);
  EXPECT_EQ(map.no_data, 254.0);
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 20; ++column) {
      if (column < 9) {
        EXPECT_EQ(map.at(column, row), 255.0) << column << " " << row;
      }
      if (column > 14) {
        EXPECT_EQ(map.at(column, row), 0.0) << column << " " << row;
      }
    }
  }
}

TEST_F(VisibilityRasterTest, what_was_used_is_printed_and_stored) {
  const ProgramResult result = raster({"--observer", "690005,5325010", "--oz", "1.5", "--tz", "0.25", "--md",
                                       "12", "--cc", "1", "-o", "seen.tif"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const ReadMap map = read_map("seen.tif");
  for (const char* const part :
       {"like gdal_viewshed", "observers 1.5 above the ground", "targets 0.25 above the ground",
        "curvature 1;", "maximum distance 12", "255 visible, 0 invisible, 0 out of range"}) {
    EXPECT_TRUE(contains(result.err, part)) << part << "\n" << result.err;
    EXPECT_TRUE(contains(map.metadata.at("alidade_sight"), part)) << part;
  }
  EXPECT_EQ(map.metadata.at("alidade_observer_count"), "1");
  EXPECT_TRUE(contains(map.metadata.at("alidade_observers"), "observer 1: 690005 5325010 601.5"));
  EXPECT_TRUE(contains(map.metadata.at("alidade_ground"), "points of classes 2, 9 and 11"));
  EXPECT_TRUE(contains(map.metadata.at("alidade_command"), "alidade visibility raster garden.las"));
  EXPECT_EQ(map.metadata.at("AREA_OR_POINT"), "Area");
}

TEST_F(VisibilityRasterTest, each_tool_has_its_own_defaults_and_options_override_them) {
  ASSERT_EQ(raster({"--observer", "690005,5325010", "--md", "6", "--extent", "690000,5325000,690020,5325020",
                    "--like", "grass", "--resolution", "1", "-o", "grass.tif"})
                .exit_code,
            0);
  const ReadMap grass = read_map("grass.tif");
  EXPECT_TRUE(contains(grass.metadata.at("alidade_sight"), "like r.viewshed; observers 1.75 above"));
  EXPECT_TRUE(contains(grass.metadata.at("alidade_sight"), "curvature 0;"));
  EXPECT_EQ(grass.no_data, 255.0);
  // Only the square that the distance reaches is in the map; its corners are out of range.
  EXPECT_EQ(grass.columns, 11);
  EXPECT_EQ(grass.rows, 12);
  EXPECT_EQ(grass.at(5, 5), 1.0);
  EXPECT_EQ(grass.at(0, 0), 255.0);
  ASSERT_EQ(raster({"--observer", "690005,5325010", "--md", "6", "--vv", "9", "--iv", "8", "--ov", "7",
                    "--resolution", "1", "-o", "own.tif"})
                .exit_code,
            0);
  const ReadMap own = read_map("own.tif");
  EXPECT_EQ(own.at(5, 5), 9.0);
  EXPECT_EQ(own.at(0, 0), 7.0);
  EXPECT_EQ(own.no_data, 255.0);
}

TEST_F(VisibilityRasterTest, modes_have_their_own_values) {
  const Words two = with(k_eye, {"--observer", "690015,5325010,601.7", "--overwrite", "--mode"});
  ASSERT_EQ(raster(with(two, {"count"})).exit_code, 0);
  const ReadMap count = read_map("seen.tif");
  EXPECT_EQ(count.type, GDT_UInt16);
  EXPECT_EQ(count.no_data, 65535.0);
  EXPECT_EQ(count.at(3, 10), 1.0);
  EXPECT_EQ(count.at(17, 10), 1.0);
  ASSERT_EQ(raster(with(two, {"fraction", "--places", "2"})).exit_code, 0);
  const ReadMap fraction = read_map("seen.tif");
  EXPECT_EQ(fraction.type, GDT_Float32);
  EXPECT_EQ(fraction.no_data, -9999.0);
  EXPECT_EQ(fraction.at(3, 10), 0.5);
  ASSERT_EQ(raster(with(k_eye, {"--overwrite", "--mode", "height"})).exit_code, 0);
  const ReadMap height = read_map("seen.tif");
  EXPECT_EQ(height.type, GDT_Float32);
  EXPECT_EQ(height.at(3, 10), 0.0);
  // The line over the wall, 1.3 higher than the eye and 5 away, is 4.43 high in the middle of this cell.
  EXPECT_NEAR(height.at(15, 10), 1.7 + 1.3 * 10.5 / 5.0, 1.5);
}

TEST_F(VisibilityRasterTest, heights_count_from_that_of_the_target) {
  // From below the horizontal nothing is seen at the eye's own height: the ground is, up to the wall.
  const ProgramResult result =
      raster(with(k_eye, {"--mode", "height", "--tz", "0.4", "--extent", "690000,5325000,690009,5325020"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "visible at 0.4 above the ground 100.0 % of the cells")) << result.err;
  const ReadMap map = read_map("seen.tif");
  for (const double value : map.values) EXPECT_FLOAT_EQ(static_cast<float>(value), 0.4f);
}

TEST_F(VisibilityRasterTest, the_preview_is_an_image) {
  ASSERT_EQ(raster(with(k_eye, {"--preview", "seen.png"})).exit_code, 0);
  EXPECT_EQ(read("seen.png").substr(1, 3), "PNG");
  EXPECT_EQ(names(), (Words{"garden.las", "seen.png", "seen.tif"}));
}

TEST_F(VisibilityRasterTest, bytes_do_not_depend_on_the_number_of_threads) {
  ASSERT_EQ(raster(with(k_eye, {"--threads", "1"})).exit_code, 0);
  const std::string one = read("seen.tif");
  ASSERT_EQ(raster(with(k_eye, {"--threads", "2", "--overwrite"})).exit_code, 0);
  EXPECT_TRUE(one == read("seen.tif"));
}

TEST_F(VisibilityRasterTest, bytes_do_not_depend_on_memory) {
  // Samples of a ground of 160,000 cells and their sums lie in files.
  for (const Words& more : {Words{}, Words{"--ground-cell", "0.05", "--mode", "height"}}) {
    const Words words = with(with(k_eye, more), {"--overwrite"});
    ASSERT_EQ(raster(words).exit_code, 0);
    const std::string whole = read("seen.tif");
    ASSERT_EQ(raster(with(words, {"--memory", "1M"})).exit_code, 0);
    EXPECT_TRUE(whole == read("seen.tif"));
  }
  EXPECT_EQ(names(), (Words{"garden.las", "seen.tif"}));
}

TEST_F(VisibilityRasterTest, bad_wishes_are_errors_and_leave_no_map) {
  expect_rejected({"-o", "seen.tif"}, "missing observers");
  expect_rejected({"--observer", "690005,5325010", "--resolution", "0", "-o", "seen.tif"}, "--resolution");
  expect_rejected({"--observer", "690005,5325010", "--resolution", "0.0001", "-o", "seen.tif"},
                  "200000 x 200000 = 4e+10 cells");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.png"}, "unknown output format");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--preview", "seen.jpg"},
                  "unknown output format");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--extent", "0,0,1,1"},
                  "--extent contains no points of the cloud");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--extent", "0,0,1"},
                  "XMIN,YMIN,XMAX,YMAX");
  expect_rejected({"--observer", "691005,5325010,610", "--md", "50", "-o", "seen.tif"},
                  "no observer reaches the map");
  expect_rejected({"--observer", "691005,5325010", "-o", "seen.tif"}, "no ground below the observer");
  expect_rejected({"--observer", "nan,5325010,1", "-o", "seen.tif"}, "invalid position");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--mode", "all"},
                  "visible|count|height|fraction|size|solid-angle");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--vv", "256"}, "--visible-value");
  expect_rejected(
      {"--observer", "690005,5325010", "-o", "seen.tif", "--mode", "height", "--highest", "1", "--tz", "2"},
      "--highest does not exceed");
  for (const Words& words : {Words{"--mode", "count", "--highest", "5"},
                             {"--places", "4"},
                             {"--mode", "height", "--places", "4"},
                             {"--mode", "count", "--vv", "7"},
                             {"--mode", "fraction", "--iv", "7"},
                             {"--mode", "height", "--ov", "7"}})
    expect_rejected(with({"--observer", "690005,5325010", "-o", "seen.tif"}, words),
                    "does not apply to this map");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--vv", "7", "--iv", "7"},
                  "visible and invisible cells have the same value");
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--direction_range", "90,0"},
                  "expected the smaller angle first");
  write("seen.tif", "mine");
  EXPECT_EQ(raster(k_eye).exit_code, 2);
  EXPECT_EQ(read("seen.tif"), "mine");
}

TEST_F(VisibilityRasterTest, names_of_r_viewshed_mean_the_same) {
  const Words own = {"--like",           "grass",  "--oz", "2.5", "--tz", "0.5", "--md", "8",
                     "--horizontal-fov", "40,150", "--cc", "0.75"};
  const Words others = {
      "--like",         "grass", "--observer_elevation", "2.5",    "--target_elevation", "0.5",
      "--max_distance", "8",     "--direction_range",    "-60,50", "--refraction_coeff", "0.25"};
  std::string sights[2];
  for (const bool is_own : {true, false}) {
    const Words words =
        with({"--observer", "690005,5325010", "--resolution", "1", "-o", "seen.tif", "--overwrite"},
             is_own ? own : others);
    const ProgramResult result = raster(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    sights[is_own ? 0 : 1] = read_map("seen.tif").metadata.at("alidade_sight");
  }
  EXPECT_EQ(sights[0], sights[1]);
  EXPECT_TRUE(contains(sights[0], "curvature 0.75; maximum distance 8; azimuth 40 to 150")) << sights[0];
}

TEST_F(VisibilityRasterTest, observers_in_the_ground_are_warned_of) {
  const ProgramResult result = raster({"--observer", "690005,5325010,590", "-o", "seen.tif"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "warning")) << result.err;
  EXPECT_TRUE(contains(result.err, "observer 1")) << result.err;
}

const Words k_mast = {"--object", "690015,5325010,600,612", "--resolution", "1", "-o", "seen.tif"};

TEST_F(VisibilityRasterTest, objects_are_seen_from_the_cells) {
  const ProgramResult result =
      raster(with(k_mast, {"--oz", "1.5", "--object-spacing", "0.25", "--preview", "seen.png"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "1 object with 48 samples, at most 0.25 apart")) << result.err;
  const ReadMap share = read_map("seen.tif");
  EXPECT_EQ(share.type, GDT_Float32);
  EXPECT_EQ(share.no_data, -9999.0);
  EXPECT_EQ(share.at(17, 10), 1.0);
  EXPECT_EQ(share.metadata.at("alidade_mode"), "fraction");
  EXPECT_EQ(share.metadata.at("alidade_object_count"), "1");
  EXPECT_TRUE(contains(share.metadata.at("alidade_objects"), "object 1: 690015 5325010 612"));
  EXPECT_TRUE(contains(share.metadata.at("alidade_sight"), "eyes 1.5 above the ground; curvature 0.85714;"));
  ASSERT_EQ(raster(with(k_mast, {"--oz", "1.5", "--object-spacing", "0.25", "--mode", "size", "--overwrite"}))
                .exit_code,
            0);
  const ReadMap length = read_map("seen.tif");
  EXPECT_EQ(length.at(17, 10), 12.0);
  // Over the wall, 1.5 higher than the eye and 9.5 away, the line meets the mast 5 behind it.
  EXPECT_NEAR(length.at(0, 10), 12.0 - (3.0 + 1.5 * 5.0 / 9.5), 0.6);
  EXPECT_NEAR(share.at(0, 10), length.at(0, 10) / 12.0, 1e-6);
}

TEST_F(VisibilityRasterTest, objects_come_from_files) {
  write("masts.csv", "name,x,y,height\nlow,690015,5325010,1\nhigh,690015,5325012,30\n");
  ASSERT_EQ(
      raster({"--objects", "masts.csv", "--mode", "count", "--resolution", "1", "-o", "seen.tif"}).exit_code,
      0);
  const ReadMap count = read_map("seen.tif");
  EXPECT_EQ(count.type, GDT_UInt16);
  EXPECT_EQ(count.at(2, 10), 1.0);
  EXPECT_EQ(count.at(17, 10), 2.0);
  write("house.geojson",
        R"({"type":"Feature","properties":{"height":4},"geometry":{"type":"Polygon","coordinates":)"
        R"([[[690014,5325008],[690018,5325008],[690018,5325012],[690014,5325012],[690014,5325008]]]}})");
  ASSERT_EQ(raster({"--objects", "house.geojson", "--objects-crs", "cloud", "--mode", "solid-angle",
                    "--resolution", "1", "-o", "seen.tif", "--overwrite"})
                .exit_code,
            0);
  const ReadMap angle = read_map("seen.tif");
  EXPECT_EQ(angle.at(15, 10), -9999.0) << "inside";
  EXPECT_GT(angle.at(13, 10), 2.0) << "half a metre before a wall";
  EXPECT_GT(angle.at(13, 10), angle.at(12, 10));
}

TEST_F(VisibilityRasterTest, objects_out_of_place_are_errors_and_leave_no_map) {
  expect_rejected({"--object", "690015,5325010,600", "-o", "seen.tif"}, "invalid object");
  expect_rejected({"--object", "690015,5325010,600,599", "-o", "seen.tif"}, "object without height");
  expect_rejected(with(k_mast, {"--observer", "690005,5325010"}), "observers and objects in one map");
  expect_rejected(with(k_mast, {"--mode", "height"}), "--mode height does not apply to objects");
  expect_rejected(with(k_mast, {"--mode", "solid-angle"}),
                  "--mode solid-angle requires objects with a width");
  expect_rejected(with(k_mast, {"--horizontal-fov", "0,90"}), "a field of view does not apply to objects");
  expect_rejected(with(k_mast, {"--tz", "1"}), "--target-height does not apply to objects");
  expect_rejected(with(k_mast, {"--object-spacing", "0"}), "--object-spacing");
  expect_rejected(with(k_eye, {"--object-spacing", "2"}), "--object-spacing requires objects");
  expect_rejected(with(k_eye, {"--mode", "size"}), "--mode size requires objects");
  expect_rejected({"--object", "691015,5325010,600,612", "--md", "50", "-o", "seen.tif"},
                  "no object reaches the map");
  write("masts.csv", "x,y,height\n691015,5325010,12\n");
  expect_rejected({"--objects", "masts.csv", "-o", "seen.tif"},
                  "masts.csv:line 2: no ground below the object");
  write("bare.csv", "x,y,z\n690015,5325010,600\n");
  expect_rejected({"--objects", "bare.csv", "-o", "seen.tif"}, "bare.csv:line 2: object without a height");
  write("empty.csv", "x,y,height\n");
  expect_rejected({"--objects", "empty.csv", "-o", "seen.tif"}, "empty.csv");
}

TEST_F(VisibilityRasterTest, an_object_far_outside_is_warned_of) {
  const ProgramResult result =
      raster({"--object", "690515,5325010,600,650", "--resolution", "4", "-o", "seen.tif"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "object 1 is 497")) << result.err;
}

TEST_F(VisibilityRasterTest, clouds_in_degrees_are_rejected) {
  write_las(folder / "degrees.las",
            garden(R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
                   R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])"));
  const ProgramResult result =
      run({"visibility", "raster", "degrees.las", "--observer", "690005,5325010,602", "-o", "seen.tif"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "degrees.las: geographic coordinates")) << result.err;
}

TEST_F(VisibilityRasterTest, a_full_disk_is_an_error_that_leaves_nothing) {
  const Words words = {"visibility",     "raster",       "garden.las", "-q", "--observer",
                       "690005,5325010", "--resolution", "0.1",        "-o", "seen.tif"};
  ASSERT_EQ(run(words).exit_code, 0);
  const std::uintmax_t size = std::filesystem::file_size(folder / "seen.tif");
  std::filesystem::remove(folder / "seen.tif");
  ASSERT_GT(size, 2048u);
  // The beginning fits; all but the end fits.
  for (const std::uintmax_t bytes : {std::uintmax_t{2048}, size - 1}) {
    const ProgramResult full = run_on_full_disk(words, bytes);
    EXPECT_EQ(full.exit_code, 2) << bytes;
    EXPECT_TRUE(contains(full.err, "seen.tif")) << full.err;
    EXPECT_EQ(names(), Words{"garden.las"}) << bytes;
  }
}

}  // namespace
}  // namespace alidade::test
