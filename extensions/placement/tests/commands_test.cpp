// SPDX-License-Identifier: MIT
// What `visibility place` has in common with the other commands of its group.
#include "tests/tools/resume_test.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

TEST_F(ResumeTest, positions_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume({"visibility", "place", "square.xyz", "--observer-grid", "0.03", "--target-spacing", "0.1",
                   "--count", "3"},
                  {"-o", "positions.json"}, 12);
}

class PlaceTest : public WallSiteTest {
 protected:
  ProgramResult place(const Words& more) { return run(with({"visibility", "place", "--count", "1"}, more)); }
  void expect_error(const Words& more, const std::string& part) {
    const ProgramResult result = place(with(more, {"-o", "out.csv"}));
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(contains(result.err, "measuring spacings")) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
  }
};

TEST_F(PlaceTest, wrong_requests_are_found_before_surfaces_are_measured) {
  write("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write("map.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 1\n1 1\n");
  expect_error({"site.csv", "--observer", "900,900"}, "the observer is 1266 outside of the cloud");
  expect_error({"site.csv", "--observer", "0,0,9", "--target-classes", "77"},
               "the cloud has no points of the target classes");
  expect_error({"site.csv", "--observer", "0,0,9", "--mesh", "bad.obj"},
               "bad.obj:line 2: a face names a vertex that does not exist");
  expect_error({"map.asc", "--observer-grid", "5"}, "a raster has no points, which this result requires");
}

TEST_F(PlaceTest, the_number_of_positions_is_required) {
  const ProgramResult result = run({"visibility", "place", "site.csv", "-o", "out.csv"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "missing --count K")) << result.err;
  EXPECT_TRUE(contains(result.err, "expected alidade visibility place [OPTIONS] CLOUD...")) << result.err;
}

TEST_F(PlaceTest, meshes_and_terrains_hide_targets) {
  write("screen.obj", "v -2 -5 0\nv -2 5 0\nv -2 5 5\nv -2 -5 5\nf 1 2 3 4\n");
  const auto share = [&](const std::string& output, const Words& more) {
    const ProgramResult result = place(with({"site.csv", "--observer", "-4,0,1.5", "-o", output}, more));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string before = "1 positions see ";
    const std::size_t at = result.err.find(before);
    return at == std::string::npos ? 0.0 : std::stod(result.err.substr(at + before.size()));
  };
  const double open = share("open.csv", {}), hidden = share("hidden.csv", {"--mesh", "screen.obj"});
  EXPECT_GT(open, 20.0);
  EXPECT_LT(hidden, 0.8 * open);
}

TEST_F(PlaceTest, gdal_opens_the_positions) {
  if (shell_output("command -v ogrinfo", folder).empty()) GTEST_SKIP() << "ogrinfo of gdal-bin is not there";
  ASSERT_EQ(run({"visibility", "place", "site.csv", "--observer", "-4,0,3", "--observer", "4,0,3", "--count",
                 "2", "-q", "-o", "best.geojson"})
                .exit_code,
            0);
  const std::string layer = shell_output("ogrinfo -al -so -ro best.geojson", folder);
  EXPECT_TRUE(contains(layer, "Feature Count: 2")) << layer;
  EXPECT_TRUE(contains(layer, "covered: Real")) << layer;
}

}  // namespace
}  // namespace alidade::test
