// SPDX-License-Identifier: MIT
// Long runs that make maps, or look at the sky and the sun.
#include <fmt/format.h>

#include "tests/tools/resume_test.h"

namespace alidade::test {
namespace {

const Words k_raster = {"visibility", "raster", "yard.xyz", "--observer", "1.5,2.7,1.6", "--radius", "0.1"};
const Words k_noon = {"--from", "2026-06-21", "--place", "48,11", "--step", "240", "--radius", "0.1"};

class MapsResumeTest : public ResumeTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("yard.xyz", yard(60));
  }

  /// Ground, so many points of 0.1 along a side, and a wall in the middle.
  static std::string yard(int points) {
    std::string text;
    const auto add = [&text](int x, int y, int z) {
      for (const int number : {x, y, z}) text += fmt::format("{:.1f} ", 0.1 * number);
      text += "\n";
    };
    for (int i = 0; i < points * points; ++i) add(i % points, i / points, 0);
    for (int i = 0; i < 20 * 10; ++i) add(points / 2, points / 2 + i % 20, 1 + i / 20);
    return text;
  }
  /// Expects an error about a difference from the command of the checkpoint, and no output.
  void expect_another_run(const Words& command, const std::string& difference) {
    const ProgramResult result = run(with(command, {"--resume"}));
    EXPECT_EQ(result.exit_code, 2) << difference;
    EXPECT_TRUE(contains(result.err, "state: this checkpoint belongs to another run: it has " + difference))
        << result.err;
    EXPECT_FALSE(contains(result.err, "discs block")) << "surfaces were measured before: " << result.err;
    EXPECT_EQ(names(), (Words{"state", "yard.xyz"}));
  }
};

TEST_F(MapsResumeTest, maps_of_what_is_seen_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(with(k_raster, {"--mode", "fraction", "--places", "5", "--resolution", "0.05"}),
                  {"-o", "seen.tif", "--preview", "seen.png"}, 4);
}

TEST_F(MapsResumeTest, lowest_heights_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(
      with(k_raster, {"--mode", "height", "--vertical-fov", "-60,60", "--cc", "1", "--resolution", "0.02"}),
      {"-o", "height.tif"}, 4);
}

TEST_F(MapsResumeTest, maps_of_objects_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(
      {"visibility", "raster", "yard.xyz", "--object", "4.5,2.7,0,3", "--object-spacing", "0.2",
       "--object-width", "0.3", "--mode", "solid-angle", "--radius", "0.1", "--resolution", "0.02"},
      {"-o", "seen.tif", "--preview", "seen.png"}, 4);
}

TEST_F(MapsResumeTest, summaries_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  write("wide.xyz", yard(150));
  kill_and_resume({"visibility", "summary", "wide.xyz", "--observer-grid", "3", "--radius", "0.1", "--step",
                   "10", "--directions", "16"},
                  {"-o", "summary.csv"}, 4);
}

TEST_F(MapsResumeTest, maps_of_the_sky_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(
      {"visibility", "sky", "yard.xyz", "--resolution", "0.04", "--directions", "8", "--radius", "0.1"},
      {"-o", "sky.tif"}, 4);
}

TEST_F(MapsResumeTest, maps_of_the_sun_killed_at_many_moments_have_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(with({"visibility", "sun", "yard.xyz", "--resolution", "0.04"}, k_noon),
                  {"-o", "sun.tif", "--preview", "sun.png"}, 4);
}

TEST_F(MapsResumeTest, sky_of_points_killed_at_many_moments_has_the_bytes_of_an_uninterrupted_run) {
  write("wide.xyz", yard(150));
  kill_and_resume({"visibility", "sky", "wide.xyz", "--directions", "8", "--radius", "0.1"},
                  {"-o", "sky.las"}, 4);
}

TEST_F(MapsResumeTest, a_map_resumes_from_a_checkpoint_of_the_same_run_only) {
  const Words words =
      with(k_raster, {"--mode", "fraction", "--places", "8", "-o", "seen.tif", "--checkpoint", "state"});
  const Words fine = with(words, {"--resolution", "0.05"});
  interrupt(fine);
  EXPECT_EQ(run(fine).exit_code, 2) << "neither gone on from nor replaced";
  expect_another_run(with(words, {"--resolution", "0.1"}), "--resolution 0.05, this run has 0.1");
  expect_another_run(with(fine, {"--tz", "1"}), "--target-height none, this run has 1");
  expect_another_run(
      {"visibility", "raster", "yard.xyz", "--object", "1,2,0,3", "--radius", "0.1", "--mode", "fraction",
       "--places", "8", "-o", "seen.tif", "--checkpoint", "state", "--resolution", "0.05"},
      "");
  expect_another_run(with(fine, {"--observer", "1,2,7"}), "--observer 1.5,2.7,1.6, this run has");
  expect_another_run({"visibility", "sky", "yard.xyz", "-o", "sky.tif", "--checkpoint", "state"},
                     "command raster, this run has sky");
  write("yard.xyz", read("yard.xyz") + "2 2 0.5\n");
  expect_another_run(fine, "number of points 3800, this run has 3801");
}

TEST_F(MapsResumeTest, a_run_for_another_day_does_not_go_on_from_the_checkpoint) {
  const Words words{"visibility", "sun", "yard.xyz", "--resolution", "0.01",  "--place",
                    "48,11",      "-o",  "sun.tif",  "--checkpoint", "state", "--from"};
  interrupt(with(words, {"2026-06-21"}));
  expect_another_run(with(words, {"2026-06-22"}), "--from 2026-06-21, this run has 2026-06-22");
}

TEST_F(MapsResumeTest, the_checkpoint_is_neither_map_nor_image) {
  for (const std::string name : {"seen.tif", "seen.png"}) {
    const ProgramResult result =
        run(with(k_raster, {"-o", "seen.tif", "--preview", "seen.png", "--checkpoint", name}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, name + ": two outputs have this name")) << result.err;
  }
}

}  // namespace
}  // namespace alidade::test
