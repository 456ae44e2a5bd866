// SPDX-License-Identifier: MIT
// The job itself is tested in tests/jobs/raster_test.cpp.

#include <fmt/format.h>
#include <gdal.h>
#include <array>
#include <map>

#include "base/shown_text.h"
#include "cloud/las/write_las.h"
#include "tests/support/garden.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

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

TEST_F(VisibilityRasterTest, bytes_do_not_depend_on_the_number_of_threads) {
  ASSERT_EQ(raster(with(k_eye, {"--threads", "1"})).exit_code, 0);
  const std::string one = read("seen.tif");
  ASSERT_EQ(raster(with(k_eye, {"--threads", "2", "--overwrite"})).exit_code, 0);
  EXPECT_TRUE(one == read("seen.tif"));
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

TEST_F(VisibilityRasterTest, a_dry_run_prints_the_plan_and_writes_nothing) {
  const Words words = {"--observer", "690005,5325010", "-o",         "seen.tif", "--preview",
                       "seen.png",   "--checkpoint",   "seen.state", "--dry-run"};
  const ProgramResult result = raster(words);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(
      result.out.substr(0, result.out.find("needs")),
      fmt::format("reads   garden.las  {} points, {}\n"
                  "writes  seen.tif\nwrites  seen.png\nwrites  seen.state\n",
                  garden(k_metres).size(),
                  quantity(static_cast<double>(std::filesystem::file_size(folder / "garden.las")), "B")));
  EXPECT_EQ(names(), Words{"garden.las"});
  // What the run would reject, the dry run rejects.
  EXPECT_EQ(raster({"--observer", "690005,5325010", "-o", "garden.las", "--dry-run"}).exit_code, 2);
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

}  // namespace
}  // namespace alidade::test
