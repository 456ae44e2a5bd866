// SPDX-License-Identifier: MIT
// Long runs of `alidade visibility` that are killed, interrupted and resumed.
#include <fmt/format.h>

#include "tests/tools/resume_test.h"

namespace alidade::test {
namespace {

const Words k_points = {"visibility", "points", "square.xyz"};

TEST_F(ResumeTest, points_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(with(k_points, {"--observer-grid", "0.3", "--fraction", "99", "--blockers", "all"}),
                  {"-o", "seen.las", "--lists", "who.csv"}, 12);
}

TEST_F(ResumeTest, a_checkpoint_holds_no_absolute_path) {
  std::string eyes = "x,y,z\n";
  for (int i = 0; i < 1000; ++i) eyes += std::to_string(100 + 0.0018 * i) + ",201,6\n";
  write("eyes.csv", eyes);
  interrupt({"visibility", "points", folder / "square.xyz", "--observers", folder / "eyes.csv", "--fraction",
             "255", "-o", folder / "seen.las", "--checkpoint", "state"});
  EXPECT_FALSE(contains(read("state"), folder.string()));
  EXPECT_TRUE(contains(read("state"), "eyes.csv in folder "));
}

TEST_F(ResumeTest, interrupted_it_keeps_a_checkpoint_and_ends_with_130) {
  const Words words = with(
      k_points, {"--observer-grid", "0.05", "--fraction", "255", "-o", "seen.las", "--checkpoint", "state"});
  interrupt(words);
  EXPECT_EQ(names(), (Words{"square.xyz", "state"}));

  const ProgramResult rejected = run(words);
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(contains(rejected.err, "state: the file exists; expected --resume")) << rejected.err;
  const ProgramResult other = run(with(words, {"--resume", "--transparency", "2"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(
      other.err, "state: this checkpoint belongs to another run: it has --transparency none, this run has 2"))
      << other.err;
  write("square.xyz", read("square.xyz") + "101 201 5.5\n");
  const ProgramResult cloud = run(with(words, {"--resume"}));
  EXPECT_EQ(cloud.exit_code, 2);
  EXPECT_TRUE(contains(cloud.err, "it has number of points 400, this run has 401")) << cloud.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "seen.las"));
}

TEST_F(ResumeTest, other_outputs_and_threads_are_the_same_run_another_reference_system_is_not) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "600", "--seed", "1", "-o", "site.las"}).exit_code, 0);
  const Words asked = {"visibility", "points", "site.las", "--observer-grid", "25", "--fraction", "30"};
  const Words whole = {"-o", "whole.las", "--lists", "whole.csv", "--threads", "1"};
  ASSERT_EQ(run(with(asked, whole)).exit_code, 0);
  const Words keep = with(asked, {"--checkpoint", "state", "--checkpoint-interval", "0.001"});
  Program program(with(keep, {"-o", "a.las", "--lists", "a.csv", "--threads", "1"}), folder);
  wait_for_a_part(program);
  program.send(SIGKILL);
  ASSERT_EQ(program.wait().signal, SIGKILL);

  const Words others = with(keep, {"--resume", "-o", "b.las", "--lists", "b.csv", "--threads", "2"});
  const std::string site = read("site.las");
  std::string moved = site;
  const std::size_t zone = moved.find("zone 32N");
  ASSERT_NE(zone, std::string::npos);
  moved[zone + 6] = '3';
  write("site.las", moved);
  const ProgramResult rejected = run(others);
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(
      contains(rejected.err, "state: this checkpoint belongs to another run: it has reference system "))
      << rejected.err;

  write("site.las", site);
  const ProgramResult resumed = run(others);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_TRUE(contains(resumed.err, "alidade: resuming from state: ")) << resumed.err;
  EXPECT_TRUE(read("b.las") == read("whole.las"));
  EXPECT_TRUE(read("b.csv") == read("whole.csv"));
}

TEST_F(ResumeTest, without_a_checkpoint_yet_resume_starts_with_a_message) {
  const Words words = with(k_points, {"--observer", "101,201,7"});
  ASSERT_EQ(run(with(words, {"-o", "whole.las"})).exit_code, 0);
  const ProgramResult result = run(with(with(words, k_keep), {"-o", "out.las"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "no checkpoint state: starting from the beginning")) << result.err;
  EXPECT_TRUE(read("out.las") == read("whole.las"));
  EXPECT_EQ(names(), (Words{"out.las", "square.xyz", "whole.las"}));
}

TEST_F(ResumeTest, file_that_is_no_checkpoint_is_never_replaced_by_one) {
  write("notes.txt", "precious");
  for (const std::string flag : {"--overwrite", "--resume"}) {
    const ProgramResult rejected =
        run(with(k_points, {"--observer", "101,201,7", "-o", "out.las", "--checkpoint", "notes.txt", flag}));
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, "notes.txt:byte 0: not a visibility checkpoint")) << rejected.err;
    EXPECT_EQ(read("notes.txt"), "precious");
  }
  const ProgramResult same =
      run(with(k_points, {"--observer", "101,201,7", "-o", "out.las", "--checkpoint", "./out.las"}));
  EXPECT_EQ(same.exit_code, 2);
  EXPECT_TRUE(contains(same.err, "./out.las: two outputs have this name")) << same.err;
}

// Maps, and answers about the sky and the sun.

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
