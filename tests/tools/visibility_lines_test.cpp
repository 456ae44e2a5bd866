// SPDX-License-Identifier: MIT
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class VisibilityLinesTest : public WallSiteTest {
 protected:
  ProgramResult lines(std::vector<std::string> words) {
    words.insert(words.begin(), {"visibility", "lines", "site.csv", "-q"});
    return run(words);
  }
};

std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream stream(row);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// Rows by the names of the columns.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::istringstream stream(csv);
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> names = cells_of(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = cells_of(line);
    rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) rows.back()[names.at(i)] = cells[i];
  }
  return rows;
}

TEST_F(VisibilityLinesTest, every_position_is_paired_with_every_other) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n-4,0,3,high\n");
  const ProgramResult result = lines({"--places", "positions.csv", "-o", "lines.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out + result.err, "");
  auto rows = rows_of(read("lines.csv"));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0]["from"] + rows[0]["to"], "westeast");
  EXPECT_EQ(rows[0]["visible"], "0");
  EXPECT_EQ(rows[0]["blocker_class"], "6");
  EXPECT_NEAR(std::stod(rows[0]["blocker_at"]), 4.0, 1e-2);
  EXPECT_EQ(rows[1]["from"] + rows[1]["to"], "westhigh");
  EXPECT_EQ(rows[1]["visible"], "1");
  EXPECT_EQ(rows[1]["blocker"], "");
  EXPECT_EQ(rows[2]["from"] + rows[2]["to"], "easthigh");
  EXPECT_EQ(rows[2]["visible"], "0") << "from 1 to 3 it passes the wall's top at 2";
}

TEST_F(VisibilityLinesTest, pairs_are_given_by_names_or_by_coordinates) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,2.5,east\n");
  write("names.csv", "from,to\neast,west\n");
  write("coordinates.csv",
        "from_x,from_y,from_z,to_x,to_y,to_z,to_height,from,to\n4,0,2.5,-4,0,0,1,east,west\n");
  EXPECT_EQ(lines({"--places", "positions.csv", "--pairs", "names.csv", "-o", "a.csv"}).exit_code, 0);
  EXPECT_EQ(lines({"--pairs", "coordinates.csv", "-o", "b.csv"}).exit_code, 0);
  EXPECT_EQ(read("a.csv"), read("b.csv"));
  EXPECT_EQ(rows_of(read("a.csv")).size(), 1u);
}

TEST_F(VisibilityLinesTest, geojson_of_a_cloud_without_reference_system_warns) {
  write("pairs.csv", "from_x,from_y,from_z,to_x,to_y,to_z\n-4,0,1,4,0,1\n");
  const ProgramResult result =
      run({"visibility", "lines", "site.csv", "--pairs", "pairs.csv", "-o", "lines.geojson"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("lines.geojson: has the coordinates of the cloud"), std::string::npos)
      << result.err;
  EXPECT_NE(result.err.find("0 of 1 lines are free"), std::string::npos) << result.err;
  const Json file = Json::parse(read("lines.geojson"));
  ASSERT_EQ(file["features"].size(), 2u);
  EXPECT_EQ(file["features"][1]["geometry"]["coordinates"][1], Json({4.0, 0.0, 1.0}));
}

TEST_F(VisibilityLinesTest, transparency_sees_through_one_wall_and_occluders_are_chosen) {
  write("pairs.csv", "from_x,from_y,from_z,to_x,to_y,to_z\n-4,0,1,4,0,1\n");
  const auto visible = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--pairs", "pairs.csv", "-o", "l.csv", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = lines(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return rows_of(read("l.csv"))[0]["visible"];
  };
  EXPECT_EQ(visible({}), "0");
  EXPECT_EQ(visible({"--transparency", "2"}), "1");
  EXPECT_EQ(visible({"--ignore-classes", "6"}), "1");
  const ProgramResult rejected = lines({"--pairs", "pairs.csv", "-o", "m.csv", "--end-margin", "4"});
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_NE(rejected.err.find("--end-margin exceeds the line from"), std::string::npos) << rejected.err;
  EXPECT_EQ(visible({"--end-margin", "3.5"}), "0");
}

TEST_F(VisibilityLinesTest, results_do_not_depend_on_threads) {
  write("positions.csv", "x,y,z,name\n-4,0,1,a\n4,0,1,b\n-4,0,3,c\n3,2,2,d\n-1,-2,0.5,e\n");
  const std::vector<std::string> words = {"--places", "positions.csv"};
  for (const char* const threads : {"1", "3"}) {
    std::vector<std::string> with = words;
    with.insert(with.end(), {"--threads", threads, "-o", std::string("lines") + threads + ".json"});
    ASSERT_EQ(lines(with).exit_code, 0);
  }
  EXPECT_EQ(read("lines1.json"), read("lines3.json"));
}

TEST_F(VisibilityLinesTest, what_cannot_be_done_is_an_error) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n");
  write("one.csv", "x,y,z,name\n-4,0,1,west\n");
  write("same.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,west\n");
  write("names.csv", "from,to\nwest,north\n");
  const auto fails_with = [&](const std::vector<std::string>& words, const std::string& part) {
    const ProgramResult result = lines(words);
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  };
  fails_with({"-o", "l.csv"}, "missing lines of sight");
  fails_with({"--places", "one.csv", "-o", "l.csv"}, "one.csv: contains a single position");
  fails_with({"--places", "positions.csv", "-o", "l.txt"}, "l.txt: unknown output format");
  fails_with({"--places", "positions.csv", "--pairs", "names.csv", "-o", "l.csv"},
             "names.csv:line 2: unknown position 'north'");
  fails_with({"--pairs", "names.csv", "-o", "l.csv"}, "unknown position 'west'; expected named positions");
  write("own.csv", "from_x,from_y,to_x,to_y\n-4,0,4,0\n");
  fails_with({"--places", "positions.csv", "--pairs", "own.csv", "-o", "l.csv"},
             "own.csv: pairs given as coordinates, but --places requires names");
  fails_with({"--pairs", "own.csv", "--places-crs", "EPSG:4326", "-o", "l.csv"},
             "--places-crs requires --places");
  fails_with({"--places", "same.csv", "--pairs", "names.csv", "-o", "l.csv"},
             "same.csv: duplicate position 'west'; expected unique names");
  fails_with(
      {"--places", "positions.csv", "--earth-radius-factor", "1", "--transparency", "2", "-o", "l.csv"},
      "transparency requires straight lines");
  fails_with({"--places", "positions.csv", "--end-margin", "-1", "-o", "l.csv"}, "--end-margin");
  fails_with({"--places", "positions.csv", "--end-margin", "4", "-o", "l.csv"},
             "--end-margin exceeds the line from 'west' to 'east'; expected less than half of its length 8");
  write(
      "positions.geojson",
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[9,48]}}]})");
  fails_with({"--places", "positions.geojson", "-o", "l.csv"}, "expected --places-crs cloud");
  fails_with({"--places", "positions.csv", "-o", "positions.csv"},
             "positions.csv: the output is also an input");
  write("there.csv", "mine");
  fails_with({"--places", "positions.csv", "-o", "there.csv"}, "the file exists");
  EXPECT_EQ(read("there.csv"), "mine");
  EXPECT_EQ(names(), (std::vector<std::string>{"names.csv", "one.csv", "own.csv", "positions.csv",
                                               "positions.geojson", "same.csv", "site.csv", "there.csv"}));
}

TEST_F(VisibilityLinesTest, wrong_positions_are_found_before_surfaces_are_measured) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,west\n");
  write("names.csv", "from,to\nwest,north\n");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"lines", "site.csv", "--places", "positions.csv", "--pairs", "names.csv"},
        {"lines", "site.csv", "--places", "positions.csv", "--earth-radius-factor", "1", "--transparency",
         "2"}}) {
    std::vector<std::string> all = {"visibility"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"-o", "out.csv"});
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(result.err.find("measuring spacings"), std::string::npos) << result.err;
  }
}

TEST_F(VisibilityLinesTest, names_in_capitals_determine_the_form_as_well) {
  write("POSITIONS.CSV", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n");
  for (const std::string extension : {"csv", "json", "geojson"}) {
    ASSERT_EQ(lines({"--places", "POSITIONS.CSV", "-o", "a." + extension}).exit_code, 0);
    ASSERT_EQ(lines({"--places", "POSITIONS.CSV", "-o",
                     extension == "csv"    ? "A.CSV"
                     : extension == "json" ? "A.JSON"
                                           : "A.GEOJSON"})
                  .exit_code,
              0);
  }
  EXPECT_EQ(read("a.csv"), read("A.CSV"));
  EXPECT_EQ(read("a.json"), read("A.JSON"));
  EXPECT_EQ(read("a.geojson"), read("A.GEOJSON"));
}

TEST_F(VisibilityLinesTest, names_of_clouds_in_capitals_determine_the_form_as_well) {
  for (const std::string name : {"a.las", "A.LAS", "A.Ply"})
    ASSERT_EQ(run({"visibility", "points", "site.csv", "--observer", "-4,0,1", "-q", "-o", name}).exit_code,
              0);
  EXPECT_EQ(read("a.las"), read("A.LAS"));
  EXPECT_EQ(read("A.Ply").substr(0, 3), "ply");
}

TEST_F(VisibilityLinesTest, two_outputs_of_one_name_are_rejected) {
  const ProgramResult result = run({"visibility", "points", "site.csv", "--observer", "-4,0,1", "-o",
                                    "seen.las", "--lists", "./seen.las", "--overwrite"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("./seen.las: two outputs have this name"), std::string::npos) << result.err;
}

TEST_F(VisibilityLinesTest, ends_a_million_kilometres_away_take_no_time) {
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n1e6,0,1,far\n1e9,10,1e5,farther\n");
  const ProgramResult result =
      lines({"--places", "positions.csv", "--earth-radius-factor", "1", "-o", "lines.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(rows_of(read("lines.csv")).size(), 6u);
}

TEST_F(VisibilityLinesTest, other_programs_open_the_features) {
  if (shell_output("command -v ogrinfo", folder).empty()) GTEST_SKIP() << "ogrinfo (gdal-bin) is not there";
  const auto ogrinfo = [&](const std::string& file) {
    return shell_output("ogrinfo -al -so -ro " + file, folder);
  };
  write("positions.csv", "x,y,z,name\n-4,0,1,west\n4,0,1,east\n-4,0,3,high\n");
  ASSERT_EQ(lines({"--places", "positions.csv", "-o", "lines.geojson"}).exit_code, 0);
  // Two lines are cut in two by the wall.
  EXPECT_NE(ogrinfo("lines.geojson").find("Feature Count: 5"), std::string::npos) << ogrinfo("lines.geojson");
  EXPECT_NE(ogrinfo("lines.geojson").find("Geometry: 3D Line String"), std::string::npos);
  ASSERT_EQ(run({"visibility", "horizon", "site.csv", "--observer", "-4,0,1", "--step", "30", "-q", "-o",
                 "horizon.geojson"})
                .exit_code,
            0);
  EXPECT_NE(ogrinfo("horizon.geojson").find("Feature Count: 13"), std::string::npos)
      << ogrinfo("horizon.geojson");
}

TEST_F(VisibilityLinesTest, a_full_disk_is_an_error_that_leaves_nothing) {
  std::string positions = "x,y,z\n";
  for (int i = 0; i < 20; ++i) positions += fmt::format("{},3,1\n", 0.4 * i - 4.0);
  write("positions.csv", positions);
  for (const std::string output : {"l.csv", "l.json", "l.geojson"}) {
    ASSERT_EQ(lines({"--places", "positions.csv", "-o", output}).exit_code, 0);
    const std::uintmax_t size = std::filesystem::file_size(folder / output);
    std::filesystem::remove(folder / output);
    for (const std::uintmax_t bytes : {std::uintmax_t{4096}, size - 1}) {
      const ProgramResult full = run_on_full_disk(
          {"visibility", "lines", "site.csv", "-q", "--places", "positions.csv", "-o", output}, bytes);
      EXPECT_EQ(full.exit_code, 2) << output << " " << bytes;
      EXPECT_NE(full.err.find(output + ": cannot write the file"), std::string::npos) << full.err;
      EXPECT_EQ(names(), (std::vector<std::string>{"positions.csv", "site.csv"})) << output << " " << bytes;
    }
  }
}

TEST_F(VisibilityLinesTest, help_gives_units_and_examples) {
  const ProgramResult result = run({"visibility", "lines", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"metres", "from_x", "unscanned", "Examples:"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace alidade::test
