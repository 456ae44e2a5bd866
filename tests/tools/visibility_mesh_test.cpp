// SPDX-License-Identifier: MIT
// --mesh of all commands of `alidade visibility`: a screen before the wall of the site.
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstring>

#include "cloud/read_cloud.h"
#include "tests/tools/resume_test.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

/// A rectangle across the x axis, from y = -3 to 3.
std::string screen(double x, double height) {
  return fmt::format("v {0} -3 0\nv {0} 3 0\nv {0} 3 {1}\nv {0} -3 {1}\nf 1 2 3 4\n", x, height);
}

class VisibilityMeshTest : public WallSiteTest {
 protected:
  void SetUp() override {
    WallSiteTest::SetUp();
    write("screen.obj", screen(-2, 5));
  }

  ProgramResult visibility(const std::string& command, const Words& words) {
    ProgramResult result = run(with({"visibility", command, "site.csv", "--overwrite"}, words));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  }

  /// The number after `before` in the messages of a command, without and with the screen.
  std::array<double, 2> said(const std::string& command, const Words& words, const std::string& before) {
    std::array<double, 2> numbers{};
    for (std::size_t i = 0; i < 2; ++i) {
      const ProgramResult result =
          visibility(command, i == 0 ? words : with(words, {"--mesh", "screen.obj"}));
      const std::size_t at = result.err.rfind(before);
      EXPECT_NE(at, std::string::npos) << result.err;
      if (at != std::string::npos) numbers[i] = std::stod(result.err.substr(at + before.size()));
      EXPECT_EQ(contains(result.err, "2 triangles from screen.obj"), i == 1) << result.err;
    }
    return numbers;
  }
};

TEST_F(VisibilityMeshTest, lines_are_blocked_and_name_the_position_alone) {
  write("places.csv", "x,y,z,name\n-4,0,3,west\n4,0,3,east\n");
  visibility("lines", {"--places", "places.csv", "-o", "open.json"});
  visibility("lines", {"--places", "places.csv", "--mesh", "screen.obj", "-o", "hidden.json"});
  EXPECT_EQ(Json::parse(read("open.json"))["lines"][0]["visible"], true);
  const Json line = Json::parse(read("hidden.json"))["lines"][0];
  EXPECT_EQ(line["visible"], false);
  EXPECT_TRUE(line["blocker"].is_null());
  EXPECT_TRUE(line["blocker_class"].is_null());
  EXPECT_NEAR(line["blocker_at"], 2.0, 1e-8);
  EXPECT_NEAR(line["blocker_x"], -2.0, 1e-8);
  visibility("lines", {"--places", "places.csv", "--mesh", "screen.obj", "-o", "hidden.geojson"});
  const Json parts = Json::parse(read("hidden.geojson"))["features"];
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(parts[0]["geometry"]["coordinates"][1][0], -2.0, 1e-8);
}

TEST_F(VisibilityMeshTest, points_behind_it_have_the_blocker_minus_two) {
  visibility("points", {"--observer", "-4,0,1.5", "--mesh", "screen.obj", "-o", "seen.las"});
  const std::filesystem::path file = folder / "seen.las";
  const PointCloud cloud = read_cloud({&file, 1});
  std::vector<std::int64_t> blockers(cloud.size());
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name != "Blocker") continue;
    ASSERT_EQ(dimension.type, ScalarType::int64);
    std::memcpy(blockers.data(), dimension.values.data(), dimension.values.size());
  }
  int hidden = 0;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const glm::dvec3 position = cloud.world(id);
    if (position.x < -1.9 || std::fabs(position.y) > 2.9) continue;
    ++hidden;
    ASSERT_EQ(blockers[id], -2) << id;
  }
  EXPECT_GT(hidden, 500);
}

TEST_F(VisibilityMeshTest, raster_sky_and_sun_see_less) {
  const auto [cells, fewer_cells] =
      said("raster", {"--observer", "-4,0,1.5", "--resolution", "0.5", "-o", "seen.tif"}, "; visible ");
  EXPECT_GT(cells, 50.0);
  EXPECT_LT(fewer_cells, 0.8 * cells);
  EXPECT_GT(fewer_cells, 0.2 * cells);
  const auto [sky, less_sky] = said("sky", {"--directions", "64", "-o", "sky.las"}, "mean ");
  EXPECT_LT(less_sky, 0.98 * sky);
  EXPECT_GT(less_sky, 0.5 * sky);
  const Words day = {"--from", "2026-06-21", "--step", "60", "--place", "48,11", "--resolution", "0.5"};
  const auto [sun, less_sun] = said("sun", with(day, {"-o", "sun.tif"}), "mean ");
  EXPECT_LT(less_sun, 0.98 * sun);
  EXPECT_GT(less_sun, 0.5 * sun);
}

TEST_F(VisibilityMeshTest, the_horizon_is_its_edge) {
  const ProgramResult result =
      visibility("horizon", {"--observer", "-4,0.03,1", "--step", "90", "--mesh", "screen.obj"});
  // 4 m higher than the eye and 2 m away.
  EXPECT_TRUE(contains(result.out, "\n90,63.43,4.4")) << result.out;
  EXPECT_TRUE(contains(result.out, ",,-2,0.03,4.99")) << result.out;
}

TEST_F(VisibilityMeshTest, several_meshes_block_together) {
  write("low.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n-3 -3 0\n-3 3 0\n-3 0 2\n3 0 1 "
        "2\n");
  write("places.csv", "x,y,z,name\n-4,0,1,west\n-1,0,1,east\n-1,0,5,high\n");
  write("pairs.csv", "from,to\nwest,east\nwest,high\n");
  const ProgramResult result =
      visibility("lines", {"--places", "places.csv", "--pairs", "pairs.csv", "--mesh", "screen.obj", "--mesh",
                           "low.ply", "-o", "lines.json"});
  EXPECT_TRUE(contains(result.err, "; 3 triangles")) << result.err;
  const Json lines = Json::parse(read("lines.json"))["lines"];
  EXPECT_NEAR(lines[0]["blocker_at"], 1.0, 1e-8);
  EXPECT_NEAR(lines[1]["blocker_x"], -2.0, 1e-8);
}

TEST_F(VisibilityMeshTest, a_bad_mesh_is_an_error_of_every_command_before_the_cloud_is_loaded) {
  write("bad.csv", "x,y,z\n1,2,nothing\n");
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("places.csv", "x,y,z\n-4,0,1\n-1,0,1\n");
  for (const Words& words :
       {Words{"points", "--observer", "0,0,1", "-o", "out.las"},
        Words{"raster", "--observer", "0,0,1", "-o", "out.tif"}, Words{"horizon", "--observer", "0,0,1"},
        Words{"sky", "-o", "out.las"}, Words{"sun", "--from", "2026-06-21", "-o", "out.las"},
        Words{"lines", "--places", "places.csv", "-o", "out.csv"}}) {
    const ProgramResult result = run(with(with({"visibility"}, words), {"bad.csv", "--mesh", "bad.obj"}));
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_TRUE(contains(result.err, "error: bad.obj:line 2: a face names a vertex that does not exist"))
        << result.err;
    EXPECT_FALSE(contains(result.err, "bad.csv")) << result.err;
    const ProgramResult missing = run(with(with({"visibility"}, words), {"bad.csv", "--mesh", "none.obj"}));
    EXPECT_EQ(missing.exit_code, 2) << words[0];
    EXPECT_TRUE(contains(missing.err, "none.obj")) << missing.err;
  }
}

TEST_F(VisibilityMeshTest, a_mesh_is_never_replaced) {
  const std::string before = read("screen.obj");
  const ProgramResult result =
      run({"visibility", "points", "site.csv", "--observer", "0,0,1", "--mesh", "screen.obj", "-o", "out.las",
           "--overwrite", "--checkpoint", "./screen.obj"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "screen.obj")) << result.err;
  EXPECT_EQ(read("screen.obj"), before);
}

TEST_F(VisibilityMeshTest, renders_read_it_in_the_same_way) {
  const ProgramResult result = run({"render", "--cloud", "site.csv", "--mesh", "screen.obj", "--samples", "1",
                                    "--size", "32x24", "-o", "site.png"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "2 triangles from screen.obj")) << result.err;
}

TEST_F(ResumeTest, a_run_is_resumed_with_the_same_meshes_by_whatever_name) {
  const std::string roof = "v 100 200 7\nv 102 200 7\nv 102 202 7\nv 100 202 7\nf 1 2 3 4\n";
  write("roof.obj", roof);
  const Words asked = {"visibility", "points", "square.xyz", "--observer-grid", "0.05", "--fraction",
                       "255",        "-o",     "seen.las",   "--checkpoint",    "state"};
  interrupt(with(asked, {"--mesh", "roof.obj"}));
  write("roof.obj", roof + "v 101 201 8\nf 1 2 5\n");
  const ProgramResult other = run(with(asked, {"--mesh", "roof.obj", "--resume"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err, "state: this checkpoint belongs to another run: it has meshes "))
      << other.err;
  const ProgramResult none = run(with(asked, {"--resume"}));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_TRUE(contains(none.err, "it has meshes ")) << none.err;
  write("same.obj", "# the same\n" + roof);
  Program resumed(with(asked, {"--mesh", "same.obj", "--resume", "--checkpoint-interval", "0.001"}), folder);
  wait_while(resumed, [&] { return !contains(resumed.errors_so_far(), "resuming from state"); });
  EXPECT_TRUE(contains(resumed.errors_so_far(), "resuming from state")) << resumed.errors_so_far();
}

}  // namespace
}  // namespace alidade::test
