// SPDX-License-Identifier: MIT
#include "extensions/photos/point_colors.h"

#include <gtest/gtest.h>

namespace alidade::test {
namespace {

using namespace visibility;

ColorViews views_of(const std::vector<ColorView>& views) {
  ColorViews all;
  for (const ColorView& view : views) add_view(view, all);
  return all;
}

TEST(PointColors, positions_between_pixels_are_interpolated) {
  const image::PhotoPixels photo{.size = {2, 2},
                                 .values = {{0, 0, 0}, {100, 0, 0}, {0, 200, 0}, {100, 200, 40}}};
  using Color = std::array<std::uint8_t, 3>;
  EXPECT_EQ(color_at(photo, {0.5, 0.5}), (Color{0, 0, 0}));
  EXPECT_EQ(color_at(photo, {1.5, 0.5}), (Color{100, 0, 0}));
  EXPECT_EQ(color_at(photo, {1.0, 1.0}), (Color{50, 100, 10}));
  EXPECT_EQ(color_at(photo, {0.0, 2.0}), (Color{0, 200, 0})) << "the edges of the picture";
  EXPECT_EQ(color_at(photo, {2.0, 2.0}), (Color{100, 200, 40}));
}

TEST(PointColors, the_finest_views_are_kept_in_their_order) {
  ColorViews views;
  for (const float weight : {3.0f, 9.0f, 1.0f, 5.0f, 7.0f, 2.0f, 9.0f, 0.5f})
    add_view({weight, {static_cast<std::uint8_t>(weight), 0, 0}}, views);
  std::vector<float> weights;
  for (const ColorView& view : views) weights.push_back(view.weight);
  EXPECT_EQ(weights, (std::vector<float>{9, 9, 7, 5, 3}));
}

TEST(PointColors, one_view_is_its_colour_and_two_are_their_mean) {
  EXPECT_EQ(blended(views_of({{2.0f, {10, 20, 30}}})), Color16(2570, 5140, 7710));
  EXPECT_EQ(blended(views_of({{0.0f, {10, 20, 30}}})), Color16(2570, 5140, 7710)) << "edge-on";
  EXPECT_EQ(blended(views_of({{3.0f, {100, 0, 0}}, {1.0f, {20, 0, 8}}})), Color16(80 * 257, 0, 2 * 257));
}

TEST(PointColors, of_three_views_none_decides_alone) {
  const ColorView good{1.0f, {90, 91, 92}}, also{0.5f, {90, 91, 92}};
  for (const float weight : {0.1f, 1.0f, 1e9f})
    EXPECT_EQ(blended(views_of({good, {weight, {255, 0, 255}}, also})),
              Color16(90 * 257, 91 * 257, 92 * 257));
}

TEST(PointColors, the_median_is_weighted) {
  // Weights 4, 3, 2: half of them is reached at the middle value.
  EXPECT_EQ(blended(views_of({{4.0f, {10, 0, 0}}, {3.0f, {50, 0, 0}}, {2.0f, {60, 0, 0}}})).r, 50 * 257);
  // Weights 2, 1, 1: half of them lies between the two lower values, but one of the views weighs at most 1.8.
  EXPECT_EQ(blended(views_of({{2.0f, {10, 0, 0}}, {1.0f, {50, 0, 0}}, {1.0f, {60, 0, 0}}})).r, 50 * 257);
  EXPECT_EQ(
      blended(views_of({{1.0f, {10, 0, 0}}, {1.0f, {50, 0, 0}}, {1.0f, {60, 0, 0}}, {1.0f, {70, 0, 0}}})).r,
      55 * 257);
}

}  // namespace
}  // namespace alidade::test
