// SPDX-License-Identifier: MIT
// Flights: images of an orbit or through keyframes, and the videos of them.
#include <algorithm>
#include <cstdlib>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class FlightTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
  }

  ProgramResult fly(const Words& words) {
    return run(with({"render", "square.xyz", "--samples", "1", "--size", "24x16", "--mode", "flat"}, words));
  }
};

TEST_F(FlightTest, an_orbit_is_numbered_images_from_all_sides) {
  const ProgramResult result = fly({"--orbit", "--frames", "4", "-o", "yard_%02d.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"square.xyz", "yard_00.png", "yard_01.png", "yard_02.png",
                                               "yard_03.png"}));
  EXPECT_NE(read("yard_00.png"), read("yard_01.png"));
  const std::string second = read("yard_01.png");
  std::filesystem::remove(folder / "yard_01.png");
  // What an interrupted flight has made stays.
  EXPECT_EQ(fly({"--orbit", "--frames", "4", "-o", "yard_%02d.png", "--skip-existing"}).exit_code, 0);
  EXPECT_EQ(read("yard_01.png"), second);
}

TEST_F(FlightTest, keyframes_may_be_a_table_of_positions_and_targets) {
  write(
      "way.csv",
      "x,y,z,look_at_x,look_at_y,look_at_z\n95,195,6,101,201,5\n108,195,8,101,201,5\n108,207,6,101,201,5\n");
  const ProgramResult result = fly({"--keyframes", "way.csv", "--frames", "5", "-o", "way_%d.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names().size(), 7u);
  write("one.csv", "x,y,z,look_at_x,look_at_y,look_at_z\n95,195,6,101,201,5\n");
  EXPECT_TRUE(contains(fly({"--keyframes", "one.csv", "-o", "way_%d.png"}).err,
                       "one.csv: a flight requires two keyframes; expected more cameras"));
}

TEST_F(FlightTest, a_video_is_made_by_ffmpeg_or_the_command_is_printed) {
  const ProgramResult result = fly({"--orbit", "--frames", "6", "-o", "yard.mp4"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  if (shell_output(
          "ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 "
          "yard.mp4",
          folder)
          .empty()) {
    EXPECT_TRUE(contains(result.err, "the program ffmpeg is not installed")) << result.err;
    GTEST_SKIP() << "ffmpeg of Debian's ffmpeg is not there";
  }
  EXPECT_EQ(shell_output(
                "ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 "
                "yard.mp4",
                folder),
            "24,16,6\n");
  EXPECT_EQ(names(), (std::vector<std::string>{"square.xyz", "yard.mp4"}));
  EXPECT_TRUE(contains(fly({"--orbit", "-o", "yard.mp4"}).err, "yard.mp4")) << "replaced without --overwrite";
}

TEST_F(FlightTest, without_ffmpeg_the_images_and_the_command_stay) {
  // Only the folder of the test is searched for programs.
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.c_str(), 1);
  const ProgramResult result = fly({"--orbit", "--frames", "2", "-o", "yard.mp4"});
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(
      result.err, "no video: the program ffmpeg is not installed; the 2 images are yard_frames/%05d.png"))
      << result.err;
  EXPECT_TRUE(contains(result.err, "ffmpeg -loglevel error")) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "yard_frames/00001.png"));
}

TEST_F(FlightTest, wrong_flights_are_errors) {
  EXPECT_TRUE(contains(fly({"-o", "yard.mp4"}).err, "yard.mp4: a video requires a flight; expected --orbit"));
  EXPECT_TRUE(contains(fly({"--orbit", "--panorama", "0,0,5", "-o", "a_%d.png"}).err,
                       "--orbit and --keyframes are cameras of their own"));
  EXPECT_TRUE(contains(fly({"--orbit", "--size", "25x16", "-o", "yard.mp4"}).err,
                       "the size of a video must be even"));
  EXPECT_TRUE(contains(fly({"--orbit", "-o", "yard.png"}).err, "%04d"));
  EXPECT_EQ(names(), (std::vector<std::string>{"square.xyz"}));
}

}  // namespace
}  // namespace alidade::test
