// SPDX-License-Identifier: MIT
#include "jobs/visibility/raster.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "cloud/las/write_las.h"
#include "geo/crs_library.h"
#include "jobs/field_table.h"
#include "tests/jobs/heard.h"
#include "tests/support/garden.h"

namespace alidade::test {
namespace {

using Words = std::vector<std::string>;

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Fills a request from the words of a command line.
void give(jobs::FieldTable& table, const Words& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string name = words[i].substr(words[i].find_first_not_of('-'));
    const auto field = std::ranges::find_if(table.entries(), [&](const jobs::FieldEntry& entry) {
      return std::ranges::count(jobs::plain_names(entry), name) > 0;
    });
    const bool is_flag = field != table.entries().end() && field->form == jobs::FieldForm::flag;
    table.give(name, is_flag ? Words{} : Words{words[++i]});
  }
}

/// What a job did: its map, what it said, and its error if it failed.
struct JobResult {
  std::string error;
  Heard heard;
};

/// A map of one band.
struct Map {
  int columns = 0, rows = 0;
  std::size_t type = 0;  ///< index in ViewshedBand::values
  double no_data = 0.0;
  std::map<std::string, std::string> metadata;
  std::vector<double> values;

  double at(int column, int row) const { return values[static_cast<std::size_t>(row * columns + column)]; }
};
enum BandType : std::size_t { k_bytes, k_words, k_long_words, k_floats };

class RasterJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("alidade_raster_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    before_ = std::filesystem::current_path();
    std::filesystem::current_path(folder);
    write_las("garden.las", garden(k_metres));
  }
  void TearDown() override {
    std::filesystem::current_path(before_);
    std::filesystem::remove_all(folder);
  }

  /// Runs the job; its map is in `map`.
  JobResult raster(const Words& words, const std::string& cloud = "garden.las") {
    JobResult result;
    try {
      jobs::RasterRequest request;
      const auto table = std::make_shared<jobs::FieldTable>("raster");
      jobs::add_raster_fields(jobs::Fields(table), request);
      table->give("cloud", {cloud});
      give(*table, words);
      table->read();
      const jobs::RasterResult made = run(jobs::plan(request), result.heard);
      map = {.columns = made.grid.columns,
             .rows = made.grid.rows,
             .type = made.band.values.index(),
             .no_data = made.band.no_data,
             .metadata = {made.metadata.begin(), made.metadata.end()},
             .values = {}};
      std::visit([&](const auto& values) { map.values.assign(values.begin(), values.end()); },
                 made.band.values);
    } catch (const std::exception& error) {
      result.error = error.what();
    }
    return result;
  }

  /// Expects the job to fail with this in its message, and to leave no map.
  void expect_rejected(const Words& words, const std::string& message) {
    const JobResult result = raster(words);
    EXPECT_TRUE(contains(result.error, message)) << message << "\n" << result.error;
    EXPECT_FALSE(contains(result.heard.text(), "discs block"))
        << "surfaces were measured before: " << message;
    EXPECT_FALSE(std::filesystem::exists("seen.tif")) << message;
  }

  void write(const std::string& name, const std::string& content) { std::ofstream(name) << content; }
  std::string read(const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(name, std::ios::binary).rdbuf();
    return text.str();
  }
  Words names() const {
    Words all;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      all.push_back(entry.path().filename());
    std::ranges::sort(all);
    return all;
  }

  Map map;
  std::filesystem::path folder;

 private:
  std::filesystem::path before_;
};

const Words k_eye = {"--observer", "690005,5325010,601.7", "--resolution", "1", "-o", "seen.tif"};

TEST_F(RasterJobTest, each_tool_has_its_own_defaults_and_options_override_them) {
  ASSERT_EQ(raster({"--observer", "690005,5325010", "--md", "6", "--extent", "690000,5325000,690020,5325020",
                    "--like", "grass", "--resolution", "1", "-o", "grass.tif"})
                .error,
            "");
  const Map grass = map;
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
                .error,
            "");
  const Map own = map;
  EXPECT_EQ(own.at(5, 5), 9.0);
  EXPECT_EQ(own.at(0, 0), 7.0);
  EXPECT_EQ(own.no_data, 255.0);
}

TEST_F(RasterJobTest, modes_have_their_own_values) {
  const Words two = with(k_eye, {"--observer", "690015,5325010,601.7", "--overwrite", "--mode"});
  ASSERT_EQ(raster(with(two, {"count"})).error, "");
  const Map count = map;
  EXPECT_EQ(count.type, k_words);
  EXPECT_EQ(count.no_data, 65535.0);
  EXPECT_EQ(count.at(3, 10), 1.0);
  EXPECT_EQ(count.at(17, 10), 1.0);
  ASSERT_EQ(raster(with(two, {"fraction", "--places", "2"})).error, "");
  const Map fraction = map;
  EXPECT_EQ(fraction.type, k_floats);
  EXPECT_EQ(fraction.no_data, -9999.0);
  EXPECT_EQ(fraction.at(3, 10), 0.5);
  ASSERT_EQ(raster(with(k_eye, {"--overwrite", "--mode", "height"})).error, "");
  const Map height = map;
  EXPECT_EQ(height.type, k_floats);
  EXPECT_EQ(height.at(3, 10), 0.0);
  // The line over the wall, 1.3 higher than the eye and 5 away, is 4.43 high in the middle of this cell.
  EXPECT_NEAR(height.at(15, 10), 1.7 + 1.3 * 10.5 / 5.0, 1.5);
}

TEST_F(RasterJobTest, heights_count_from_that_of_the_target) {
  // From below the horizontal nothing is seen at the eye's own height: the ground is, up to the wall.
  const JobResult result =
      raster(with(k_eye, {"--mode", "height", "--tz", "0.4", "--extent", "690000,5325000,690009,5325020"}));
  ASSERT_EQ(result.error, "");
  EXPECT_TRUE(contains(result.heard.text(), "visible at 0.4 above the ground 100.0 % of the cells"))
      << result.heard.text();
  for (const double value : map.values) EXPECT_FLOAT_EQ(static_cast<float>(value), 0.4f);
}

TEST_F(RasterJobTest, the_preview_is_an_image) {
  ASSERT_EQ(raster(with(k_eye, {"--preview", "seen.png"})).error, "");
  EXPECT_EQ(read("seen.png").substr(1, 3), "PNG");
  EXPECT_EQ(names(), (Words{"garden.las", "seen.png", "seen.tif"}));
}

TEST_F(RasterJobTest, bad_wishes_are_errors_and_leave_no_map) {
  expect_rejected({"-o", "seen.tif"}, "missing observers");
  expect_rejected({"--observer", "690005,5325010", "--resolution", "0", "-o", "seen.tif"}, "resolution");
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
  expect_rejected({"--observer", "690005,5325010", "-o", "seen.tif", "--vv", "256"}, "visible_value");
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
  EXPECT_NE(raster(k_eye).error, "");
  EXPECT_EQ(read("seen.tif"), "mine");
}

TEST_F(RasterJobTest, names_of_r_viewshed_mean_the_same) {
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
    const JobResult result = raster(words);
    ASSERT_EQ(result.error, "");
    sights[is_own ? 0 : 1] = map.metadata.at("alidade_sight");
  }
  EXPECT_EQ(sights[0], sights[1]);
  EXPECT_TRUE(contains(sights[0], "curvature 0.75; maximum distance 8; azimuth 40 to 150")) << sights[0];
}

TEST_F(RasterJobTest, observers_in_the_ground_are_warned_of) {
  const JobResult result = raster({"--observer", "690005,5325010,590", "-o", "seen.tif"});
  EXPECT_EQ(result.error, "");
  EXPECT_EQ(result.heard.warnings.size(), 1u) << result.heard.text();
  EXPECT_TRUE(contains(result.heard.text(), "observer 1")) << result.heard.text();
}

const Words k_mast = {"--object", "690015,5325010,600,612", "--resolution", "1", "-o", "seen.tif"};

TEST_F(RasterJobTest, objects_are_seen_from_the_cells) {
  const JobResult result =
      raster(with(k_mast, {"--oz", "1.5", "--object-spacing", "0.25", "--preview", "seen.png"}));
  ASSERT_EQ(result.error, "");
  EXPECT_TRUE(contains(result.heard.text(), "1 object with 48 samples, at most 0.25 apart"))
      << result.heard.text();
  const Map share = map;
  EXPECT_EQ(share.type, k_floats);
  EXPECT_EQ(share.no_data, -9999.0);
  EXPECT_EQ(share.at(17, 10), 1.0);
  EXPECT_EQ(share.metadata.at("alidade_mode"), "fraction");
  EXPECT_EQ(share.metadata.at("alidade_object_count"), "1");
  EXPECT_TRUE(contains(share.metadata.at("alidade_objects"), "object 1: 690015 5325010 612"));
  EXPECT_TRUE(contains(share.metadata.at("alidade_sight"), "eyes 1.5 above the ground; curvature 0.85714;"));
  ASSERT_EQ(raster(with(k_mast, {"--oz", "1.5", "--object-spacing", "0.25", "--mode", "size", "--overwrite"}))
                .error,
            "");
  const Map length = map;
  EXPECT_EQ(length.at(17, 10), 12.0);
  // Over the wall, 1.5 higher than the eye and 9.5 away, the line meets the mast 5 behind it.
  EXPECT_NEAR(length.at(0, 10), 12.0 - (3.0 + 1.5 * 5.0 / 9.5), 0.6);
  EXPECT_NEAR(share.at(0, 10), length.at(0, 10) / 12.0, 1e-6);
}

TEST_F(RasterJobTest, objects_come_from_files) {
  write("masts.csv", "name,x,y,height\nlow,690015,5325010,1\nhigh,690015,5325012,30\n");
  ASSERT_EQ(
      raster({"--objects", "masts.csv", "--mode", "count", "--resolution", "1", "-o", "seen.tif"}).error, "");
  const Map count = map;
  EXPECT_EQ(count.type, k_words);
  EXPECT_EQ(count.at(2, 10), 1.0);
  EXPECT_EQ(count.at(17, 10), 2.0);
  write("house.geojson",
        R"({"type":"Feature","properties":{"height":4},"geometry":{"type":"Polygon","coordinates":)"
        R"([[[690014,5325008],[690018,5325008],[690018,5325012],[690014,5325012],[690014,5325008]]]}})");
  ASSERT_EQ(raster({"--objects", "house.geojson", "--objects-crs", "cloud", "--mode", "solid-angle",
                    "--resolution", "1", "-o", "seen.tif", "--overwrite"})
                .error,
            "");
  const Map angle = map;
  EXPECT_EQ(angle.at(15, 10), -9999.0) << "inside";
  EXPECT_GT(angle.at(13, 10), 2.0) << "half a metre before a wall";
  EXPECT_GT(angle.at(13, 10), angle.at(12, 10));
}

TEST_F(RasterJobTest, objects_out_of_place_are_errors_and_leave_no_map) {
  expect_rejected({"--object", "690015,5325010,600", "-o", "seen.tif"}, "invalid object");
  expect_rejected({"--object", "690015,5325010,600,599", "-o", "seen.tif"}, "object without height");
  expect_rejected(with(k_mast, {"--observer", "690005,5325010"}), "observers and objects in one map");
  expect_rejected(with(k_mast, {"--mode", "height"}), "--mode height does not apply to objects");
  expect_rejected(with(k_mast, {"--mode", "solid-angle"}),
                  "--mode solid-angle requires objects with a width");
  expect_rejected(with(k_mast, {"--horizontal-fov", "0,90"}), "a field of view does not apply to objects");
  expect_rejected(with(k_mast, {"--tz", "1"}), "--target-height does not apply to objects");
  expect_rejected(with(k_mast, {"--object-spacing", "0"}), "object_spacing");
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

TEST_F(RasterJobTest, an_object_far_outside_is_warned_of) {
  const JobResult result =
      raster({"--object", "690515,5325010,600,650", "--resolution", "4", "-o", "seen.tif"});
  EXPECT_EQ(result.error, "");
  EXPECT_TRUE(contains(result.heard.text(), "object 1 is 497")) << result.heard.text();
}

TEST_F(RasterJobTest, clouds_in_degrees_are_rejected) {
  write_las(folder / "degrees.las",
            garden(R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
                   R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])"));
  const JobResult result = raster({"--observer", "690005,5325010,602", "-o", "seen.tif"}, "degrees.las");
  EXPECT_TRUE(contains(result.error, "degrees.las: geographic coordinates")) << result.error;
}

}  // namespace
}  // namespace alidade::test
