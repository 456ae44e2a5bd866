// SPDX-License-Identifier: MIT
// Folders, patterns, tiles outside of the query, and damaged files, for every command that reads clouds.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

class TilesProgramTest : public ProgramTest {
 protected:
  /// A terrain of 5 by 4 tiles of 10 by 10 metres with 300 points each: tiles/tile_XY.las.
  void make_tiles() {
    fs::create_directories(folder / "tiles");
    std::mt19937 engine(11);
    for (int x = 0; x < 5; ++x) {
      for (int y = 0; y < 4; ++y) {
        PointCloud tile;
        tile.lattice = {.scale = glm::dvec3(0.001), .offset = {1000.0 + 10 * x, 2000, 100}};
        for (int i = 0; i < 300; ++i) {
          tile.positions.emplace_back(engine() % 10000, 10000 * y + engine() % 10000, engine() % 3000);
          tile.classifications.push_back(static_cast<std::uint8_t>(engine() % 3));
        }
        write_las(folder / ("tiles/tile_" + std::to_string(x) + std::to_string(y) + ".las"), tile);
      }
    }
  }

  void cut(const std::string& name, std::size_t bytes) {
    write(name, read(name).substr(0, read(name).size() - bytes));
  }

  /// Expects the answers of a query of the tiles to be those of all points; returns stderr of the former.
  std::string same_answers(const Words& targets) {
    Words of_tiles = {"query", "tiles/"}, of_all = {"query", "all.alidade", "-q"};
    of_tiles.insert(of_tiles.end(), targets.begin(), targets.end());
    of_all.insert(of_all.end(), targets.begin(), targets.end());
    const ProgramResult some = run(of_tiles), all = run(of_all);
    EXPECT_EQ(some.exit_code, 0) << some.err;
    EXPECT_EQ(all.exit_code, 0) << all.err;
    EXPECT_GT(std::ranges::count(all.out, '\n'), 1) << "no answers to compare";
    EXPECT_EQ(some.out, all.out);
    return some.err;
  }
};

TEST_F(TilesProgramTest, a_folder_and_a_pattern_are_one_cloud_for_every_command) {
  make_tiles();
  for (const char* const name : {"tiles", "tiles/", "tiles/tile_*.las", "tile[s]/*"}) {
    const ProgramResult result = run({"info", "--json", name});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json info = Json::parse(result.out);
    EXPECT_EQ(info.at("points"), 6000);
    EXPECT_EQ(info.at("files").size(), 20u);
    EXPECT_TRUE(contains(info.at("files")[7].at("file"), "tile_13.las"));
  }
  EXPECT_EQ(run({"index", "tiles", "-o", "all.alidade"}).exit_code, 0);
  EXPECT_EQ(run({"query", "tiles", "--point", "1005,2005,100", "--k", "1"}).exit_code, 0);
  EXPECT_EQ(
      run({"visibility", "points", "tiles/*.las", "--observer", "1020,2020,110", "-o", "seen.las"}).exit_code,
      0);
  const Words small = {"--size", "20x10", "--samples", "1", "-q"};
  Words render = {"render", "--cloud", "tiles/*", "-o", "cloud.png"};
  render.insert(render.end(), small.begin(), small.end());
  EXPECT_EQ(run(render).exit_code, 0);
  fs::create_directories(folder / "scenes");
  write("scenes/a.json", R"({"version": 1, "cloud": {"file": "../tiles"}, "output": {"file": "scene.png"}})");
  render = {"render", "scenes/a.json"};
  render.insert(render.end(), small.begin(), small.end());
  const ProgramResult scene = run(render);
  EXPECT_EQ(scene.exit_code, 0) << scene.err;
}

TEST_F(TilesProgramTest, names_that_match_nothing_are_errors_that_name_what_was_expected) {
  fs::create_directories(folder / "empty");
  const ProgramResult pattern = run({"info", "*.laz"}), empty = run({"query", "empty", "--point", "0,0,0"});
  EXPECT_EQ(pattern.exit_code, 2);
  EXPECT_TRUE(contains(pattern.err, "*.laz: no matching cloud file")) << pattern.err;
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_TRUE(contains(empty.err, "empty: the folder contains no cloud files")) << empty.err;
}

TEST_F(TilesProgramTest, answers_are_the_same_with_and_without_the_tiles_that_targets_do_not_reach) {
  make_tiles();
  ASSERT_EQ(run({"index", "tiles", "-o", "all.alidade", "-q"}).exit_code, 0);
  EXPECT_TRUE(
      contains(same_answers({"--ray", "1025,2015,150,0,0,-1", "--radius", "1"}), "read 1 of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--ray", "1000,2010,101,1,0.01,0", "--radius", "0.5"}), "of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--ray", "990,2005,101,1,0,0", "--radius", "2", "--t-max", "15"}),
                       "read 1 of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--cone", "1025,2015,110,0,0,-1,20"}), "of 20 files"));
  EXPECT_TRUE(
      contains(same_answers({"--vertex", "1001,2001,101", "--vertex", "1001,2031,101", "--radius", "1"}),
               "read 4 of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--box", "1011,2011,0,1018,2018,200"}), "read 1 of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--point", "1045,2035,101", "--radius", "3", "--class", "0,2"}),
                       "read 1 of 20 files"));
  EXPECT_TRUE(contains(same_answers({"--point", "1045,2035,101", "--radius", "3", "--count"}), "read 1 of"));
  EXPECT_FALSE(contains(same_answers({"--point", "1045,2035,101"}), "of 20 files")) << "without a radius";
  EXPECT_FALSE(contains(same_answers({"--ray", "900,1900,101,1,1,0", "--radius", "200"}), "of 20 files"));
}

TEST_F(TilesProgramTest, random_targets_have_the_same_answers_with_and_without_skipping) {
  make_tiles();
  ASSERT_EQ(run({"index", "tiles", "-o", "all.alidade", "-q"}).exit_code, 0);
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> offset(-2.0, 2.0), east(1000, 1050), north(2000, 2040);
  int skipped = 0;
  for (int round = 0; round < 8; ++round) {
    const double x = east(engine), y = north(engine);
    std::string rays = "ox,oy,oz,dx,dy,dz\n", cones = "ox,oy,oz,dx,dy,dz,half_angle\n";
    for (int i = 0; i < 20; ++i) {
      const std::string ray = std::to_string(x + offset(engine)) + "," + std::to_string(y + offset(engine)) +
                              ",104," + std::to_string(0.5 * offset(engine)) + "," +
                              std::to_string(0.5 * offset(engine)) + ",-1";
      rays += ray + "\n";
      cones += ray + ",5\n";
    }
    write("rays.csv", rays);
    write("cones.csv", cones);
    skipped += contains(same_answers({"--rays", "rays.csv", "--radius", "0.7"}), " of 20 files") ? 1 : 0;
    skipped += contains(same_answers({"--cones", "cones.csv", "--t-max", "8"}), " of 20 files") ? 1 : 0;
  }
  EXPECT_EQ(skipped, 16);
}

TEST_F(TilesProgramTest, targets_from_a_pipe_are_queried_in_all_tiles) {
  make_tiles();
  const ProgramResult result = run_with_input({"query", "tiles", "--rays", "-", "--radius", "1"},
                                              "ox,oy,oz,dx,dy,dz\n1025,2015,150,0,0,-1\n");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_FALSE(contains(result.err, "of 20 files"));
  EXPECT_EQ(result.out, run({"query", "tiles", "--ray", "1025,2015,150,0,0,-1", "--radius", "1"}).out);
}

TEST_F(TilesProgramTest, partial_reads_the_intact_part_and_reports_losses_whatever_the_command) {
  make_tiles();
  cut("tiles/tile_02.las", 3);
  cut("tiles/tile_31.las", 3000);
  const std::vector<Words> commands = {
      {"info", "tiles"},
      {"index", "tiles", "-o", "all.alidade"},
      {"query", "tiles", "--box", "1000,2000,0,1050,2040,200", "--count"},
      {"render", "--cloud", "tiles", "-o", "cloud.png", "--size", "20x10", "--samples", "1"},
      {"visibility", "points", "tiles", "--observer", "1020,2020,110", "-o", "seen.las"}};
  for (Words command : commands) {
    const ProgramResult rejected = run(command);
    EXPECT_EQ(rejected.exit_code, 2) << command.front();
    EXPECT_TRUE(contains(rejected.err, "tile_02.las")) << rejected.err;
    EXPECT_TRUE(contains(rejected.err, "--partial reads the intact part")) << rejected.err;
    command.emplace_back("--partial");
    const ProgramResult result = run(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "tile_02.las:byte")) << result.err;
    EXPECT_TRUE(contains(result.err, "truncated file: it ends before its last point; 1 point is lost"))
        << result.err;
    EXPECT_TRUE(contains(result.err, "tile_31.las:byte")) << result.err;
  }
  const Json info = Json::parse(run({"info", "--json", "--partial", "tiles"}).out);
  EXPECT_EQ(info.at("files")[2].at("lost"), 1);
  EXPECT_EQ(info.at("files")[2].at("points"), 299);
  EXPECT_EQ(info.at("files")[3].at("lost"), 0);
  write("a.json",
        R"({"version": 1, "cloud": {"file": "tiles", "partial": true}, "output": {"file": "a.png"}})");
  const ProgramResult scene = run({"render", "a.json", "--size", "20x10", "--samples", "1"});
  EXPECT_EQ(scene.exit_code, 0) << scene.err;
  EXPECT_TRUE(contains(scene.err, "1 point is lost")) << scene.err;
}

}  // namespace
}  // namespace alidade::test
