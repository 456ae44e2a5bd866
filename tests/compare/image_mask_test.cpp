// SPDX-License-Identifier: MIT
#include "compare/compared_image.h"

#include <gtest/gtest.h>

#include <limits>

namespace alidade::test {

using namespace compare;

namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();
constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
using Counts = std::vector<std::uint8_t>;

/// Four pixels in a row, linear grey.
ComparedImage four_pixels() {
  ComparedImage image;
  image.file = "four.exr";
  image.width = 4;
  image.height = 1;
  image.encoding = ColorEncoding::linear;
  image.color_channels = 3;
  image.color.assign(12, 0.5f);
  return image;
}

TEST(ImageMask, an_empty_mask_counts_all_pixels) {
  EXPECT_EQ(counted_pixels(ImageMask{}, 12), 12u);
  EXPECT_TRUE(ImageMask{}.at(7));
  const ImageMask mask{{1, 0, 1}};
  EXPECT_EQ(counted_pixels(mask, 3), 2u);
  EXPECT_FALSE(mask.at(1));
}

TEST(ImageMask, a_mask_image_counts_where_it_is_above_half_of_the_display_range) {
  ComparedImage drawn = four_pixels();
  drawn.encoding = ColorEncoding::display;
  drawn.color = {0, 0, 0, 1, 1, 1, 0.49f, 0.49f, 0.49f, 0.51f, 0.51f, 0.51f};
  ImageMask mask;
  keep_light(mask, drawn, four_pixels());
  EXPECT_EQ(mask.counts, (Counts{0, 1, 0, 1}));
  // Linear 0.25 is the sRGB value 0.537.
  drawn.encoding = ColorEncoding::linear;
  drawn.color.assign(12, 0.25f);
  keep_light(mask, drawn, four_pixels());
  EXPECT_EQ(mask.counts, (Counts{0, 1, 0, 1}));
  drawn.width = 2;
  drawn.height = 2;
  EXPECT_THROW(keep_light(mask, drawn, four_pixels()), SizeMismatch);
}

TEST(ImageMask, alpha_counts_from_the_given_value_on_in_every_image_that_has_it) {
  ComparedImage reference = four_pixels(), test = four_pixels();
  ImageMask mask;
  EXPECT_THROW(keep_alpha(mask, reference, test), Error);
  reference.alpha = {0.0f, 0.49f, 0.5f, 1.0f};
  keep_alpha(mask, reference, test);
  EXPECT_EQ(mask.counts, (Counts{0, 0, 1, 1}));
  test.alpha = {1.0f, 1.0f, 0.2f, 0.99f};
  keep_alpha(mask, reference, test);
  EXPECT_EQ(mask.counts, (Counts{0, 0, 0, 1}));
  mask.counts.clear();
  keep_alpha(mask, reference, test, 1.0f);
  EXPECT_EQ(mask.counts, (Counts{0, 0, 0, 0}));
}

TEST(ImageMask, depth_counts_where_it_is_finite_and_positive_in_every_image_that_has_it) {
  ComparedImage reference = four_pixels(), test = four_pixels();
  ImageMask mask;
  EXPECT_THROW(keep_valid_depth(mask, reference, test), Error);
  test.depth = {1.0f, k_infinity, k_nan, 0.0f};
  keep_valid_depth(mask, reference, test);
  EXPECT_EQ(mask.counts, (Counts{1, 0, 0, 0}));
}

TEST(ImageMask, sky_is_ignored_only_where_every_image_with_sky_shows_it) {
  ComparedImage reference = four_pixels(), test = four_pixels();
  ImageMask mask;
  EXPECT_THROW(ignore_sky(mask, reference, test), Error);
  reference.ids = {0, 0, 7, 8};
  ignore_sky(mask, reference, test);
  EXPECT_EQ(mask.counts, (Counts{0, 0, 1, 1}));
  test.depth = {k_infinity, 3.0f, k_infinity, 4.0f};
  mask.counts.clear();
  ignore_sky(mask, reference, test);
  EXPECT_EQ(mask.counts, (Counts{0, 1, 1, 1}));
}

TEST(ImageMask, rectangles_are_cut_at_the_borders_and_joined) {
  const ComparedImage image = four_pixels();
  const std::vector<image::PixelBox> rectangles{{-5, -5, 1, 9}, {3, 0, 4, 1}};
  ImageMask mask;
  keep_rectangles(mask, image, {});
  EXPECT_TRUE(mask.counts.empty());
  keep_rectangles(mask, image, rectangles);
  EXPECT_EQ(mask.counts, (Counts{1, 0, 0, 1}));
  ignore_rectangles(mask, image, std::vector<image::PixelBox>{{0, 0, 2, 1}});
  EXPECT_EQ(mask.counts, (Counts{0, 0, 0, 1}));
}

TEST(ImageMask, pixels_that_are_not_finite_are_taken_out_and_counted_once) {
  ComparedImage reference = four_pixels(), test = four_pixels();
  ImageMask mask;
  EXPECT_EQ(keep_finite(mask, reference, test), 0u);
  EXPECT_TRUE(mask.counts.empty());
  reference.color[4] = k_nan;
  test.color[3] = k_infinity;
  test.color[9] = -k_infinity;
  EXPECT_EQ(keep_finite(mask, reference, test), 2u);
  EXPECT_EQ(mask.counts, (Counts{1, 0, 1, 0}));
  EXPECT_EQ(keep_finite(mask, reference, test), 0u);
}

}  // namespace
}  // namespace alidade::test
