// SPDX-License-Identifier: MIT
#include <cmath>

#include "tests/compare/drawn_images.h"
#include "tests/tools/compare_program.h"

// Each option of `alidade compare` has an effect that can be seen.

namespace alidade::test {

using namespace compare;

namespace {

class CompareOptionsTest : public CompareTest {
 protected:
  /// A grey image as text, of numbers 0 .. 255.
  template <typename Value>
  void draw(const std::string& name, int width, int height, const Value& value) {
    std::string text = "P2\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) text += std::to_string(static_cast<int>(value(x, y))) + "\n";
    write(name, text);
  }
};

TEST_F(CompareOptionsTest, masks_crop_and_size_choose_what_counts) {
  const auto ramp = [](int x, int y) { return 5 * x + y; };
  draw("a.pgm", 40, 30, ramp);
  draw("small.pgm", 20, 15, ramp);
  draw("mask.pgm", 40, 30, [](int x, int) { return x < 8 ? 255 : 0; });
  EXPECT_EQ(found("a.pgm a.pgm")["counted"], 1200);
  EXPECT_EQ(found("a.pgm a.pgm --mask mask.pgm")["counted"], 240);
  EXPECT_EQ(found("a.pgm a.pgm --only 0,0,10,30 --only 10,0,12,5")["counted"], 310);
  EXPECT_EQ(found("a.pgm a.pgm --ignore 0,0,10,30 --ignore 5,0,12,30")["counted"], 840);
  EXPECT_EQ(found("a.pgm a.pgm --only 0,0,10,30 --ignore 0,0,40,29")["counted"], 10);
  const json part = found("a.pgm a.pgm --crop 4,5,20,25");
  EXPECT_EQ(part["pixels"], 320);
  EXPECT_EQ(compare("a.pgm small.pgm --resize none").exit_code, 2);
  EXPECT_EQ(found("a.pgm small.pgm --resize reference")["test"]["width"], 40);
}

TEST_F(CompareOptionsTest, alpha_depth_and_sky_choose_what_counts) {
  // Of the square, whose points are far apart, much is seen through.
  render("a.exr", "32x24", {"--layers", "color,depth,id", "--radius", "0.03"});
  const int all = found("a.exr a.exr")["counted"], opaque = found("a.exr a.exr --opaque")["counted"],
            valid = found("a.exr a.exr --valid-depth")["counted"],
            ground = found("a.exr a.exr --ignore-sky")["counted"];
  EXPECT_EQ(all, 32 * 24);
  for (const int some : {opaque, valid, ground}) {
    EXPECT_GT(some, 0);
    EXPECT_LT(some, all);
  }
}

TEST_F(CompareOptionsTest, colours_are_matched_and_edges_aligned) {
  const auto blot = [](double x, double y) { return 40 + 200 * blots(x, y); };
  draw("a.pgm", 96, 80, blot);
  draw("darker.pgm", 96, 80, [&](int x, int y) { return std::lround(0.8 * blot(x, y)); });
  draw("moved.pgm", 96, 80, [&](int x, int y) { return blot(x - 5, y); });
  const json matched = found("a.pgm darker.pgm --match exposure");
  EXPECT_GT(matched["match"]["scale"][0], 1.3) << "0.8 of the codes is 0.62 of the light";
  EXPECT_LT(matched["match"]["metrics"]["rmse"], 0.1 * matched["metrics"]["rmse"].get<double>());
  EXPECT_NE(found("a.pgm darker.pgm --match affine")["match"]["offset"][0], 0.0);
  const json aligned = found("a.pgm moved.pgm --align")["alignment"];
  EXPECT_TRUE(aligned["certain"]);
  EXPECT_NEAR(aligned["shift"][0], 5.0, 0.2);
  EXPECT_FALSE(found("a.pgm moved.pgm --align --largest-shift 2")["alignment"]["certain"]);
}

TEST_F(CompareOptionsTest, flip_is_seen_from_another_distance_and_in_other_exposures) {
  render("a.exr", "32x24", {"--layers", "color"});
  render("b.exr", "32x24", {"--layers", "color", "--no-sun"});
  const auto flip = [&](const std::string& words) {
    return json(
        found("a.exr b.exr --start-exposure -2 --stop-exposure 1 --exposures 3" + words)["metrics"]["flip"]);
  };
  const json plain = flip("");
  EXPECT_EQ(plain["start_exposure"], -2.0);
  EXPECT_EQ(plain["stop_exposure"], 1.0);
  EXPECT_EQ(plain["exposures"], 3);
  for (const char* const words :
       {" --pixels-per-degree 20", " --tone-mapper hable", " --tone-mapper reinhard"})
    EXPECT_NE(flip(words)["mean"], plain["mean"]) << words;
}

TEST_F(CompareOptionsTest, thresholds_and_sizes_choose_regions_of_change) {
  draw("a.pgm", 60, 40, [](int, int) { return 0; });
  draw("b.pgm", 60, 40, [](int x, int y) {
    const bool is_small = x < 8 && y < 8, is_large = x >= 30 && x < 50 && y >= 10 && y < 30;
    return is_large ? 100 : is_small ? 250 : 0;
  });
  const auto regions = [&](const std::string& words) {
    return found("a.pgm b.pgm --changes color" + words)["changes"]["regions"].size();
  };
  EXPECT_EQ(regions(""), 2u);
  EXPECT_EQ(regions(" --change-threshold 0.5"), 1u) << "the small one";
  EXPECT_EQ(regions(" --least-pixels 100"), 1u) << "the large one";
  EXPECT_EQ(regions(" --change-threshold 0.5 --least-pixels 100"), 0u);
  EXPECT_FALSE(found("a.pgm b.pgm --changes flip")["changes"]["regions"].empty());
}

TEST_F(CompareOptionsTest, pages_hold_images_as_requested) {
  draw("a.pgm", 40, 30, [](int x, int y) { return 5 * x + y; });
  for (const std::string packing : {"png", "jpeg"}) {
    EXPECT_EQ(compare("a.pgm a.pgm -q --report " + packing + ".html --report-pictures " + packing).exit_code,
              0);
    EXPECT_TRUE(contains(read(packing + ".html"), "data:image/" + packing)) << packing;
  }
  EXPECT_FALSE(contains(read("png.html"), "data:image/jpeg"));
}

}  // namespace
}  // namespace alidade::test
