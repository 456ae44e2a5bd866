// SPDX-License-Identifier: MIT
#include "visibility/lines/line_files.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "geo/earth.h"
#include "tests/cloud/crs_of_keys.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class LineFilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("line_files_" + std::to_string(::getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  /// A wall of class 6 at x = 30, and two lines: one against it, one over it.
  LineTable table() {
    const Occluders occluders = WallCloud().add({30, -2, 0}, {0, 4, 0}, {0, 0, 2}, 0.1).occluders();
    classes.assign(occluders.octree().size(), 6);
    LineTable made;
    made.pairs = {{"mast, old", {{0, 0.03, 1.02}}, "the \"roof\"", {{100, 0.03, 1.02}}},
                  {"a", {{0, 0, 3}}, "b", {{100, 0, 3}}}};
    made.reports = report_lines(occluders, made.pairs, {});
    made.classifications = classes;
    return made;
  }

  std::string written(const LineTable& lines, RowForm form, const ToLonLat& to_lon_lat = {}) {
    const fs::path file = folder / "lines";
    was_placed =
        write_lines(lines, form, {.command = "alidade x", .cloud_files = {"a.las"}}, to_lon_lat, file, true);
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  fs::path folder;
  std::vector<std::uint8_t> classes;
  bool was_placed = false;
};

/// A projected system by its EPSG number.
Crs projected(std::uint16_t number) {
  return crs_of_keys({1024, 1, 3072, number});
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST_F(LineFilesTest, form_depends_on_the_extension) {
  EXPECT_EQ(row_form("a.csv"), RowForm::csv);
  EXPECT_EQ(row_form("a.b/c.json"), RowForm::json);
  EXPECT_EQ(row_form("c.geojson"), RowForm::geojson);
  EXPECT_FALSE(row_form("c.txt"));
  EXPECT_FALSE(row_form("csv"));
}

TEST_F(LineFilesTest, csv_has_a_header_and_a_row_per_line) {
  const std::vector<std::string> rows = lines_of(written(table(), RowForm::csv));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(
      rows[0],
      "line,from,to,from_x,from_y,from_z,to_x,to_y,to_z,length,visible,blocker,blocker_class,blocker_at,"
      "blocker_x,blocker_y,blocker_z,clearance,clearance_at,clearance_point,clearance_class");
  EXPECT_TRUE(
      rows[1].starts_with("0,\"mast, old\",\"the \"\"roof\"\"\",0.0,0.03,1.02,100.0,0.03,1.02,100.0,0,"))
      << rows[1];
  EXPECT_TRUE(rows[2].starts_with("1,a,b,0.0,0.0,3.0,100.0,0.0,3.0,100.0,1,,,,,,,")) << rows[2];
  EXPECT_TRUE(rows[2].ends_with(",6")) << rows[2];
}

TEST_F(LineFilesTest, json_has_the_same_values) {
  const LineTable lines = table();
  const Json file = Json::parse(written(lines, RowForm::json));
  EXPECT_EQ(file["command"], "alidade x");
  EXPECT_EQ(file["cloud_files"], Json::array({"a.las"}));
  ASSERT_EQ(file["lines"].size(), 2u);
  const Json& hidden = file["lines"][0];
  EXPECT_EQ(hidden["to"], "the \"roof\"");
  EXPECT_EQ(hidden["visible"], false);
  EXPECT_EQ(hidden["blocker"], lines.reports[0].blocker->point_id);
  EXPECT_EQ(hidden["blocker_class"], 6);
  EXPECT_NEAR(hidden["blocker_at"], 30.0, 1e-3);
  EXPECT_EQ(file["lines"][1]["visible"], true);
  EXPECT_TRUE(file["lines"][1]["blocker"].is_null());
}

TEST_F(LineFilesTest, geojson_splits_a_blocked_line_at_the_first_obstruction) {
  const Json file = Json::parse(written(table(), RowForm::geojson));
  EXPECT_FALSE(was_placed);
  EXPECT_EQ(file["type"], "FeatureCollection");
  ASSERT_EQ(file["features"].size(), 3u);
  const Json &near = file["features"][0], &far = file["features"][1], &whole = file["features"][2];
  EXPECT_EQ(near["properties"]["visible"], true);
  EXPECT_EQ(far["properties"]["visible"], false);
  EXPECT_EQ(near["properties"]["blocker"], far["properties"]["blocker"]);
  EXPECT_TRUE(far["properties"]["blocker"].is_number_unsigned());
  EXPECT_EQ(near["geometry"]["type"], "LineString");
  EXPECT_EQ(near["geometry"]["coordinates"][0], Json({0.0, 0.03, 1.02}));
  EXPECT_EQ(near["geometry"]["coordinates"][1], far["geometry"]["coordinates"][0]);
  EXPECT_NEAR(far["geometry"]["coordinates"][0][0], 30.0, 1e-3);
  EXPECT_EQ(far["geometry"]["coordinates"][1], Json({100.0, 0.03, 1.02}));
  EXPECT_EQ(whole["properties"]["visible"], true);
  EXPECT_EQ(whole["properties"]["line"], 1);
}

TEST_F(LineFilesTest, a_line_blocked_at_its_start_is_one_hidden_part) {
  LineTable lines = table();
  lines.reports[0].blocker->distance = 0.0;
  const Json file = Json::parse(written(lines, RowForm::geojson));
  ASSERT_EQ(file["features"].size(), 2u);
  EXPECT_EQ(file["features"][0]["properties"]["visible"], false);
}

TEST_F(LineFilesTest, geojson_has_longitude_and_latitude_where_they_are_known) {
  const Crs utm = projected(32632);
  const auto to_lon_lat = [&](std::span<const glm::dvec3> positions) {
    std::vector<glm::dvec3> moved(positions.begin(), positions.end());
    for (glm::dvec3& position : moved) position += glm::dvec3(500000, 5325000, 0);
    return lon_lat(utm, moved);
  };
  const Json file = Json::parse(written(table(), RowForm::geojson, to_lon_lat));
  EXPECT_TRUE(was_placed);
  // 500000 is the central meridian of zone 32; a degree of latitude has 111 km.
  const Json& start = file["features"][0]["geometry"]["coordinates"][0];
  EXPECT_EQ(start[0], 9.0);
  EXPECT_NEAR(start[1], 48.08, 0.01);
  EXPECT_EQ(start[2], 1.02);
  const Json& end = file["features"][2]["geometry"]["coordinates"][1];
  EXPECT_NEAR(end[0].get<double>() - 9.0, 100.0 / (111320.0 * std::cos(48.08 * 3.14159265 / 180.0)), 5e-6);
}

TEST_F(LineFilesTest, an_existing_file_is_not_replaced_unasked) {
  const fs::path file = folder / "lines.csv";
  const LineTable lines = table();
  write_lines(lines, RowForm::csv, {}, {}, file, false);
  EXPECT_THROW(write_lines(lines, RowForm::csv, {}, {}, file, false), Error);
  EXPECT_NO_THROW(write_lines(lines, RowForm::csv, {}, {}, file, true));
}

TEST_F(LineFilesTest, a_mesh_has_a_position_but_neither_id_nor_class) {
  LineTable lines = table();
  lines.reports[0].blocker->point_id = k_mesh_blocker;
  const Json hidden = Json::parse(written(lines, RowForm::json))["lines"][0];
  EXPECT_EQ(hidden["visible"], false);
  EXPECT_TRUE(hidden["blocker"].is_null());
  EXPECT_TRUE(hidden["blocker_class"].is_null());
  EXPECT_NEAR(hidden["blocker_at"], 30.0, 1e-3);
  EXPECT_NEAR(hidden["blocker_x"], 30.0, 1e-3);
  EXPECT_NE(written(lines, RowForm::csv).find(",0,,,3"), std::string::npos) << written(lines, RowForm::csv);
}

TEST(LonLat, unknown_and_local_systems_are_empty) {
  const std::vector<glm::dvec3> origin = {{0, 0, 0}};
  EXPECT_FALSE(lon_lat({}, origin));
  EXPECT_FALSE(lon_lat(crs_of_wkt("LOCAL_CS[\"here\",UNIT[\"metre\",1]]"), origin));
  EXPECT_FALSE(lon_lat(crs_of_wkt("nonsense"), origin));
}

TEST(LonLat, metres_of_a_unit) {
  EXPECT_EQ(metres_per_unit({}), 1.0);
  EXPECT_FALSE(metres_per_unit(crs_of_wkt("nonsense")));
  EXPECT_EQ(metres_per_unit(projected(32632)), 1.0);
  EXPECT_NEAR(*metres_per_unit(projected(2229)), 0.3048006, 1e-7);
  Crs degrees;
  degrees.geotiff_keys = {1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326};
  EXPECT_FALSE(metres_per_unit(degrees));
}

std::filesystem::path written(const std::string& text) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "pair_table_test.csv";
  std::ofstream(path) << text;
  return path;
}

std::string problem_of(const std::string& text) {
  const std::filesystem::path path = written(text);
  try {
    read_pair_table(path);
  } catch (const Error& error) {
    return std::string(error.what()).substr(path.string().size());
  }
  return "";
}

TEST(PairTable, names_alone_are_pairs_of_positions_known_elsewhere) {
  const std::vector<GivenPair> pairs = read_pair_table(written("to,from\nmast,roof\n\n\"a, b\",c\n"));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_FALSE(pairs[0].has_positions);
  EXPECT_EQ(pairs[0].from.name, "roof");
  EXPECT_EQ(pairs[0].to.name, "mast");
  EXPECT_EQ(pairs[1].to.name, "a, b");
  EXPECT_TRUE(pairs[1].from.source.ends_with("pair_table_test.csv:line 4"));
}

TEST(PairTable, positions_may_lack_z_height_and_name) {
  const std::vector<GivenPair> pairs = read_pair_table(
      written("from_x,from_y,from_z,from_height,to_x,to_y,to_z,to\n1,2,3,10,4,5,,mast\n-1e2,0.5,,,0,0,7,\n"));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_TRUE(pairs[0].has_positions);
  EXPECT_EQ(pairs[0].from.position, glm::dvec2(1, 2));
  EXPECT_EQ(pairs[0].from.z, 3.0);
  EXPECT_EQ(pairs[0].from.height, 10.0);
  EXPECT_EQ(pairs[0].to.position, glm::dvec2(4, 5));
  EXPECT_FALSE(pairs[0].to.z);
  EXPECT_EQ(pairs[0].to.name, "mast");
  EXPECT_EQ(pairs[1].from.position, glm::dvec2(-100, 0.5));
  EXPECT_FALSE(pairs[1].from.height);
  EXPECT_EQ(pairs[1].to.z, 7.0);
}

TEST(PairTable, errors_name_the_line) {
  EXPECT_TRUE(problem_of("").starts_with(": contains no pairs"));
  EXPECT_TRUE(problem_of("from,to\n").starts_with(": contains no pairs"));
  EXPECT_TRUE(problem_of("from,until\na,b\n").starts_with(":line 1: unknown column"));
  EXPECT_TRUE(problem_of("from,from\na,b\n").starts_with(":line 1: duplicate column from"));
  EXPECT_TRUE(problem_of("from\na\n").starts_with(":line 1: missing columns"));
  EXPECT_TRUE(problem_of("from,to,from_x,from_y\na,b,1,2\n").starts_with(":line 1: missing columns"));
  EXPECT_TRUE(problem_of("from,to,from_z\na,b,1\n").starts_with(":line 1: missing columns"));
  const std::string header = "from_x,from_y,to_x,to_y\n";
  EXPECT_EQ(problem_of(header + "1,2,3,4\n"), "");
  EXPECT_TRUE(problem_of(header + "1,2,3\n").starts_with(":line 2: too few columns"));
  EXPECT_TRUE(problem_of(header + "1,2,3,4,5\n").starts_with(":line 2: too many columns"));
  EXPECT_TRUE(
      problem_of(header + "\n1,2,x,4\n").starts_with(":line 3: invalid to_x; expected a finite number"));
  EXPECT_TRUE(problem_of(header + "1,2,,4\n").starts_with(":line 2: invalid to_x; expected a finite number"));
  EXPECT_TRUE(
      problem_of(header + "1,nan,3,4\n").starts_with(":line 2: invalid from_y; expected a finite number"));
  EXPECT_TRUE(
      problem_of(header + "1,inf,3,4\n").starts_with(":line 2: invalid from_y; expected a finite number"));
  EXPECT_TRUE(problem_of("from,to\na,\n").starts_with(":line 2: missing endpoint name"));
}

}  // namespace

}  // namespace alidade::test
