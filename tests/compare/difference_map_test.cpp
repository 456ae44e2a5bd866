// SPDX-License-Identifier: MIT
#include "compare/difference_map.h"

#include <gtest/gtest.h>

#include <OpenImageIO/imagebuf.h>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "base/error.h"
#include "image/font.h"
#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

constexpr float k_infinite = std::numeric_limits<float>::infinity();

ComparedImage even(int width, int height, double value, ColorEncoding encoding = ColorEncoding::display) {
  return draw_image(width, height, encoding, [=](int, int) {
    return std::array<double, 3>{value, value, value};
  });
}

/// 4 x 1 pixels: as far, 2 cm farther, gone, new.
struct DepthPair {
  ComparedImage reference = even(5, 1, 0.5), test = even(5, 1, 0.5);

  DepthPair() {
    reference.depth = {10.0f, 10.0f, 10.0f, k_infinite, k_infinite};
    test.depth = {10.0f, 10.5f, k_infinite, 10.0f, k_infinite};
  }
};

TEST(DifferenceMap, of_colours_is_the_largest_channel_in_display_values) {
  ComparedImage reference = even(2, 1, 0.5), test = even(2, 1, 0.5);
  test.color[1] = 0.25f;
  test.color[2] = 0.625f;
  const DifferenceMap map = color_difference(reference, test, {});
  EXPECT_EQ(map.values, (std::vector<float>{0.25f, 0.0f}));
  // Linear light is turned into display values first: 0.214041 is half of white (IEC 61966-2-1).
  const DifferenceMap mixed =
      color_difference(even(1, 1, 0.214041, ColorEncoding::linear), even(1, 1, 0.25), {});
  EXPECT_NEAR(mixed.values[0], 0.25f, 1e-4f);
}

TEST(DifferenceMap, of_colours_that_are_no_numbers_has_nothing_there) {
  ComparedImage reference = even(3, 1, 0.5, ColorEncoding::linear), test = reference;
  reference.color[1] = std::numeric_limits<float>::quiet_NaN();
  test.color[5] = k_infinite;
  const DifferenceMap map = color_difference(reference, test, {});
  EXPECT_TRUE(std::isnan(map.values[0]));
  EXPECT_TRUE(std::isnan(map.values[1]));
  EXPECT_EQ(map.values[2], 0.0f);
}

TEST(DifferenceMap, of_equal_images_still_has_a_range) {
  const DifferenceMap map = color_difference(even(8, 8, 0.5), even(8, 8, 0.5), {});
  EXPECT_EQ(map.range, (ValueRange{0.0, 1.0 / 255.0}));
}

TEST(DifferenceMap, range_follows_the_percentile_of_what_counts) {
  ComparedImage reference = even(1000, 1, 0.0),
                test = draw_image(1000, 1, ColorEncoding::display, [](int x, int) {
                  return std::array<double, 3>{x / 1000.0, 0.0, 0.0};
                });
  EXPECT_NEAR(color_difference(reference, test, {}).range.high, 0.994, 1e-3);
  ImageMask half;
  half.counts.assign(1000, 0);
  std::fill_n(half.counts.begin(), 500, std::uint8_t{1});
  EXPECT_NEAR(color_difference(reference, test, half).range.high, 0.497, 2e-3);
}

TEST(DifferenceMap, of_depth_is_signed_and_marks_what_only_one_image_has) {
  const DepthPair pair;
  const DifferenceMap map = depth_difference(pair.reference, pair.test, {});
  EXPECT_EQ(map.values[0], 0.0f);
  EXPECT_EQ(map.values[1], 0.5f);
  EXPECT_EQ(map.values[2], k_infinite);
  EXPECT_EQ(map.values[3], -k_infinite);
  EXPECT_TRUE(std::isnan(map.values[4]));
  EXPECT_EQ(map.range.low, -map.range.high);
  EXPECT_NE(map.label.find("(m)"), std::string::npos);
}

TEST(DifferenceMap, of_depth_takes_what_is_no_depth_for_nothing) {
  ComparedImage reference = even(6, 1, 0.5), test = reference;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  reference.depth = {0.0f, 4.0f, -1.0f, nan, 0.0f, 4.0f};
  test.depth = {4.0f, 0.0f, k_infinite, 4.0f, nan, -k_infinite};
  const DifferenceMap map = depth_difference(reference, test, {});
  EXPECT_EQ(map.values[0], -k_infinite);
  EXPECT_EQ(map.values[1], k_infinite);
  EXPECT_TRUE(std::isnan(map.values[2]));
  EXPECT_EQ(map.values[3], -k_infinite);
  EXPECT_TRUE(std::isnan(map.values[4]));
  EXPECT_EQ(map.values[5], k_infinite);
}

TEST(DifferenceMap, painted_pixel_for_pixel_every_kind_of_pixel_has_its_own_colour) {
  const DepthPair pair;
  DifferenceMap map = depth_difference(pair.reference, pair.test, {});
  map.range = {-0.5, 0.5};
  const Canvas canvas = paint_difference(map);
  EXPECT_EQ(canvas.width(), 5);
  EXPECT_EQ(canvas.height(), 1);
  std::set<Rgb8> colors;
  for (int x = 0; x < 5; ++x) colors.insert(canvas.at(x, 0));
  map.mask.counts.assign(5, 0);
  colors.insert(paint_difference(map).at(1, 0));
  EXPECT_EQ(colors.size(), 6u);
  // Farther away is red, no difference nearly white.
  EXPECT_GT(canvas.at(1, 0)[0], canvas.at(1, 0)[2]);
  EXPECT_GT(canvas.at(0, 0)[1], 230);
}

TEST(DifferenceMap, of_large_images_shows_the_strongest_value_of_each_square) {
  const Font font(find_font());
  std::vector<float> values(400 * 300, 0.0f);
  values[151 * 400 + 203] = 1.0f;
  const DifferenceMap map = flip_difference(values, 400, {});
  const auto has_yellow = [](const Canvas& canvas, const PixelBox& box) {
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x)
        if (canvas.at(x, y)[0] > 200 && canvas.at(x, y)[1] > 200) return true;
    return false;
  };
  for (const int longest_side : {400, 200, 100}) {
    const Canvas canvas = draw_difference(map, font, longest_side);
    // The map without its frame; the legend is beside it.
    const PixelBox box{24, 64, 24 + longest_side, 64 + longest_side * 3 / 4};
    EXPECT_TRUE(has_yellow(canvas, box)) << longest_side;
  }
}

TEST(DifferenceMap, is_written_as_png_with_a_legend_beside_it) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "difference.png";
  const DifferenceMap map = flip_difference(std::vector<float>(200 * 100, 0.5f), 200, {});
  EXPECT_EQ(map.range, (ValueRange{0.0, 1.0}));
  write_difference(map, file, true);
  const OIIO::ImageBuf image(file.string());
  EXPECT_GT(image.spec().width, 200 + 100);
  EXPECT_GE(image.spec().height, 100);
  EXPECT_THROW(write_difference(map, file, false), Error);
  EXPECT_THROW(write_difference(map, std::filesystem::temp_directory_path() / "difference.jpg", true), Error);
}

TEST(DifferenceMap, nothing_to_compare_is_an_error) {
  ComparedImage nothing = even(3, 2, 0.5);
  nothing.depth.assign(6, k_infinite);
  const DifferenceMap map = depth_difference(nothing, nothing, {});
  EXPECT_NE(map.notes.front().find("no pixel"), std::string::npos);
  EXPECT_GT(map.range.high, 0.0);
  const Font font(find_font());
  EXPECT_GT(draw_difference(map, font).width(), 0);
}

TEST(DifferenceMap, images_of_two_sizes_are_an_error) {
  EXPECT_THROW(color_difference(even(2, 2, 0.5), even(2, 3, 0.5), {}), SizeMismatch);
  EXPECT_THROW(depth_difference(even(2, 2, 0.5), even(2, 3, 0.5), {}), SizeMismatch);
}

}  // namespace
}  // namespace alidade::test
