// SPDX-License-Identifier: MIT
#include "tests/jobs/render_job.h"

namespace alidade::test {
namespace {

class RenderLightTest : public RenderJobTest {
 protected:
  void SetUp() override {
    RenderJobTest::SetUp();
    write_square("square.xyz");
  }
  RenderOutcome render(Words words) {
    words.insert(words.begin(), {"--size=24x16", "--samples=4", "--overwrite"});
    return RenderJobTest::render(words);
  }
  /// Of the square, which has no reference system.
  RenderOutcome render_square(Words words) {
    words.insert(words.begin(), {"--cloud", "square.xyz", "-o", "out.png"});
    return render(words);
  }
};

TEST_F(RenderLightTest, sun_by_time_and_position_is_printed_and_stored) {
  const RenderOutcome result =
      render_square({"--sun-time", "2003-10-17T12:30:30-07:00", "--sun-place", "39.742476,-105.1786"});
  ASSERT_TRUE(result.is_done) << result.said;
  // Another air than the published example's changes the elevation by less than 0.01 degrees.
  EXPECT_TRUE(contains(result.said, "sun at azimuth 194.34")) << result.said;
  EXPECT_TRUE(contains(result.said, "(+y assumed to be true north), elevation 39.8")) << result.said;
  EXPECT_TRUE(contains(read("out.png"), "alidade:sun")) << "not stored";
  EXPECT_TRUE(contains(read("out.png"), "2003-10-17T19:30:30Z at latitude 39.742476"));
}

TEST_F(RenderLightTest, sun_of_a_cloud_with_a_map_needs_no_position_and_is_turned_to_grid_north) {
  write_yard("yard.las", 2000);
  const RenderOutcome result =
      render({"--cloud", "yard.las", "-o", "out.png", "--sun-time", "2026-06-21T10:00:00Z"});
  ASSERT_TRUE(result.is_done) << result.said;
  EXPECT_TRUE(contains(result.said, "from +y: grid north is 1.89")) << result.said;
  EXPECT_TRUE(contains(result.said, "at latitude 48.0")) << result.said;
}

TEST_F(RenderLightTest, sun_below_the_horizon_lights_nothing_with_a_warning) {
  const RenderOutcome night =
      render_square({"--sun-time", "2026-12-21T23:00:00+01:00", "--sun-place", "48,11.5"});
  ASSERT_TRUE(night.is_done) << night.said;
  EXPECT_TRUE(contains(night.said, "the sun is below the horizon, at elevation -6")) << night.said;
  const std::string at_night = pixels("out.png");
  ASSERT_TRUE(render_square({"--no-sun"}).is_done);
  EXPECT_EQ(pixels("out.png"), at_night);
  ASSERT_TRUE(render_square({}).is_done);
  EXPECT_NE(pixels("out.png"), at_night);
}

TEST_F(RenderLightTest, sun_by_angles_is_the_one_a_scene_would_have) {
  write("a.json",
        R"({"version": 1, "cloud": {"file": "square.xyz"}, "sun": {"azimuth": 200, "elevation": 25}})");
  write("b.json", R"({"version": 1, "cloud": {"file": "square.xyz"}, "sun": {}})");
  ASSERT_TRUE(render({"a.json", "-o", "a.png"}).is_done);
  ASSERT_TRUE(render({"b.json", "--sun", "200,25", "-o", "b.png"}).is_done);
  EXPECT_EQ(pixels("a.png"), pixels("b.png"));
}

TEST_F(RenderLightTest, mistakes_about_the_sun_are_errors_that_explain) {
  const auto expect = [&](const Words& words, const std::string& part) {
    const RenderOutcome result = render_square(words);
    EXPECT_FALSE(result.is_done) << result.said;
    EXPECT_TRUE(contains(result.said, part)) << result.said;
  };
  expect({"--sun-time", "2026-06-21T12:00:00"}, "missing time zone");
  expect({"--sun-time", "noon"}, "invalid date and time");
  expect({"--sun-time", "2026-06-21T12:00:00Z"}, "the sun position requires latitude and longitude");
  expect({"--sun-place", "48,11"}, "--sun-time DATE-TIME, found none");
  expect({"--sun-time", "2026-06-21T12:00:00Z", "--sun-place", "48"},
         "expected two numbers separated by a comma, found");
  expect({"--sun-time", "2026-06-21T12:00:00Z", "--sun-place", "91,11"}, "sun_place");
  expect({"--sun", "100"}, "expected two numbers separated by a comma, found");
  expect({"--sun", "100,-90"}, "above -90");
  expect({"--sun", "100,20", "--no-sun"}, "excludes");
  expect({"--sun", "100,20", "--sun-time", "2026-06-21T12:00:00Z"}, "excludes");
  expect({"--ao-distance", "2"}, "--mode ambient_occlusion");
  expect({"--mode", "ao"}, "expected path|ambient_occlusion|headlight|flat");
}

TEST_F(RenderLightTest, options_that_a_mode_does_not_use_are_errors) {
  const std::string moment = "2026-06-21T12:00:00Z";
  for (const std::string mode : {"ambient_occlusion", "headlight", "flat"}) {
    for (const Words& words : std::vector<Words>{
             {"--sun", "10,20"}, {"--sun-time", moment}, {"--sun-place", "48,11"}, {"--max-bounces", "3"}}) {
      const RenderOutcome result = render_square({"--mode", mode, words[0], words[1]});
      EXPECT_FALSE(result.is_done);
      const std::string said = " does not apply to this mode; expected --mode path, found " + mode;
      EXPECT_TRUE(contains(result.said, words[0] + said)) << result.said;
    }
    // --no-sun requests what these modes do anyway.
    EXPECT_TRUE(render_square({"--mode", mode, "--no-sun"}).is_done);
  }
}

TEST_F(RenderLightTest, blanks_are_allowed_where_people_write_them) {
  const auto sun = [&](const std::string& time, const std::string& location) {
    const RenderOutcome result = render_square({"--sun-time", time, "--sun-place", location});
    EXPECT_TRUE(result.is_done) << result.said;
    return result.said.substr(0, result.said.find("elevation"));
  };
  EXPECT_EQ(sun("2026-06-21 12:00:00+02:00", " 48.1, 11.6 "), sun("2026-06-21T12:00:00+02:00", "48.1,11.6"));
  EXPECT_TRUE(render_square({"--sun", "100 , 20"}).is_done);
  for (const std::string location : {"48 1,11", "48,", " , ", "48,11,3"})
    EXPECT_FALSE(render_square({"--sun-time", "2026-06-21T12:00:00Z", "--sun-place", location}).is_done)
        << location;
}

TEST_F(RenderLightTest, ambient_occlusion_without_a_cloud_reaches_any_distance) {
  write("ball.json", R"({"version": 1, "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}],
    "camera": {"model": "pinhole", "width": 24, "height": 16, "intrinsics": {"vertical_fov": 50},
               "pose": {"look_at": {"eye": [0, -4, 1], "target": [0, 0, 0]}}}})");
  const RenderOutcome result = render({"ball.json", "--mode", "ambient_occlusion", "-o", "out.png"});
  EXPECT_TRUE(result.is_done) << result.said;
  EXPECT_TRUE(contains(result.said, "ambient occlusion at any distance (there is no cloud to set the range)"))
      << result.said;
}

TEST_F(RenderLightTest, a_panorama_is_a_sky) {
  ASSERT_TRUE(render({"--cloud", "square.xyz", "--panorama", "101,201,6", "-o", "sky.exr"}).is_done);
  write("scene.json", R"({"version": 1, "sky": {"type": "image", "file": "sky.exr"},
    "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1,
                 "material": {"type": "metal", "albedo": [0.9, 0.9, 0.9]}}],
    "camera": {"model": "pinhole", "width": 24, "height": 16, "intrinsics": {"vertical_fov": 50},
               "pose": {"look_at": {"eye": [0, -4, 1], "target": [0, 0, 0]}}}})");
  const RenderOutcome result = render({"scene.json", "-o", "ball.png"});
  ASSERT_TRUE(result.is_done) << result.said;
  EXPECT_TRUE(contains(result.said, "sky from sky.exr, 24 x 16 pixels")) << result.said;
  // The sky itself is safe from being overwritten by its image.
  EXPECT_FALSE(render({"scene.json", "-o", "sky.exr"}).is_done);
  EXPECT_TRUE(RenderJobTest::render({"scene.json", "-o", "missing.png"}).is_done);
  std::filesystem::remove(folder / "sky.exr");
  const RenderOutcome missing = render({"scene.json", "-o", "ball.png"});
  EXPECT_FALSE(missing.is_done);
  EXPECT_TRUE(contains(missing.said, "sky.exr: no such file (at /sky/file of scene.json)")) << missing.said;
}

TEST_F(RenderLightTest, quick_modes_need_no_light_and_are_named_in_messages) {
  write("dark.json", R"({"version": 1, "cloud": {"file": "square.xyz"}, "sky": {"type": "constant"},
    "sun": {"date_time": "2026-06-21T12:00:00Z"}})");
  std::string last;
  for (const std::string mode : {"ambient_occlusion", "headlight", "flat"}) {
    const RenderOutcome result = render({"dark.json", "--mode", mode, "-o", "out.png"});
    ASSERT_TRUE(result.is_done) << result.said;
    EXPECT_TRUE(contains(read("out.png"), "alidade:mode"));
    EXPECT_EQ(contains(read("out.png"), "alidade:ao_distance"), mode == "ambient_occlusion");
    EXPECT_EQ(contains(result.said, "ambient occlusion within"), mode == "ambient_occlusion") << result.said;
    EXPECT_NE(pixels("out.png"), last);
    last = pixels("out.png");
  }
  // The path mode requires latitude and longitude for its sun.
  EXPECT_FALSE(render({"dark.json", "-o", "out.png"}).is_done);
}

}  // namespace
}  // namespace alidade::test
