// SPDX-License-Identifier: MIT
#include "compare/metrics/agreement.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare/difference_map.h"
#include "compare/metrics/errors.h"
#include "image/font.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();
constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();

ComparedImage with_depth(const std::vector<float>& depth, const std::vector<float>& sigma = {}) {
  ComparedImage image;
  image.file = "layers";
  image.width = static_cast<int>(depth.size());
  image.height = 1;
  image.depth = depth;
  image.depth_sigma = sigma;
  return image;
}

std::vector<Agreement> agreements(const ComparedImage& reference, const ComparedImage& test) {
  const DepthAgreement agreement(reference, test);
  std::vector<Agreement> found;
  for (std::size_t pixel = 0; pixel < reference.pixels(); ++pixel) found.push_back(agreement.at(pixel));
  return found;
}

using enum Agreement;

// sqrt(3^2 + 4^2) = 5 quarters: the limit is 3.75 m, which itself agrees.
TEST(Agreement, limit_is_three_standard_deviations_of_the_difference) {
  const ComparedImage reference = with_depth({10.0f, 10.0f, 10.0f}, {0.75f, 0.75f, 0.75f});
  const ComparedImage test = with_depth({13.75f, 13.8125f, 6.25f}, {1.0f, 1.0f, 1.0f});
  EXPECT_EQ(agreements(reference, test), (std::vector{agrees, differs, agrees}));
  EXPECT_EQ(agreements(test, reference), (std::vector{agrees, differs, agrees}));
}

TEST(Agreement, an_image_without_the_layer_has_no_error) {
  const ComparedImage reference = with_depth({10.0f, 10.0f, 10.0f});
  const ComparedImage test = with_depth({10.75f, 10.8125f, 10.0f}, {0.25f, 0.25f, 0.0f});
  EXPECT_EQ(agreements(reference, test), (std::vector{agrees, differs, agrees}));
}

TEST(Agreement, infinite_sigma_agrees_with_any_depth_and_with_none) {
  const ComparedImage reference = with_depth({10.0f, k_infinity});
  const ComparedImage test = with_depth({500.0f, 7.0f}, {k_infinity, k_infinity});
  EXPECT_EQ(agreements(reference, test), (std::vector{agrees, agrees}));
}

TEST(Agreement, values_that_are_no_sigma_are_zero) {
  const ComparedImage reference = with_depth({10.0f, 10.0f, 10.0f});
  const ComparedImage test = with_depth({10.5f, 10.5f, 10.5f}, {k_nan, -1.0f, 1.0f});
  EXPECT_EQ(agreements(reference, test), (std::vector{differs, differs, agrees}));
}

// Pixels: seen by the truth only, by the scan only, by neither.
TEST(Agreement, a_scan_without_points_is_no_difference_and_a_surface_in_empty_air_is) {
  const std::vector<float> in_truth{10.0f, k_infinity, k_infinity, 5.0f};
  const ComparedImage scan =
      with_depth({k_infinity, 7.0f, 0.0f, 5.0f}, {k_infinity, 0.01f, k_infinity, 0.01f});
  // Renders of exact surfaces have the layer too if it is requested: 0, and infinite where nothing is.
  for (const ComparedImage& truth :
       {with_depth(in_truth), with_depth(in_truth, {0.0f, k_infinity, k_infinity, 0.0f})}) {
    EXPECT_EQ(agreements(truth, scan), (std::vector{not_scanned, differs, nothing, agrees}));
    EXPECT_EQ(agreements(scan, truth), (std::vector{not_scanned, differs, nothing, agrees}));
  }
}

TEST(Agreement, what_one_of_two_scans_lacks_is_not_scanned) {
  const ComparedImage before = with_depth({10.0f, k_infinity, 10.0f}, {0.01f, k_infinity, 0.01f});
  const ComparedImage after = with_depth({k_infinity, 10.0f, 11.0f}, {k_infinity, 0.01f, 0.01f});
  EXPECT_EQ(agreements(before, after), (std::vector{not_scanned, not_scanned, differs}));
  const ComparedImage empty =
      with_depth({k_infinity, k_infinity, k_infinity}, {k_infinity, k_infinity, k_infinity});
  EXPECT_EQ(agreements(before, empty), (std::vector{not_scanned, nothing, not_scanned}));
}

TEST(Agreement, metrics_count_the_pixels_that_count) {
  const ComparedImage reference = with_depth({10.0f, 10.0f, 10.0f, 10.0f, k_infinity, 10.0f});
  const ComparedImage test = with_depth({10.0f, 10.0f, 11.0f, k_infinity, k_infinity, 10.0f},
                                        {0.1f, 0.1f, 0.1f, k_infinity, k_infinity, 0.1f});
  const AgreementMetrics metrics = *layer_metrics(reference, test).agreement;
  EXPECT_EQ(metrics.agreeing, 3u);
  EXPECT_EQ(metrics.differing, 1u);
  EXPECT_EQ(metrics.not_scanned, 1u);
  const AgreementMetrics masked = *layer_metrics(reference, test, {{1, 0, 1, 0, 1, 1}}).agreement;
  EXPECT_EQ(masked.agreeing, 2u);
  EXPECT_EQ(masked.differing, 1u);
  EXPECT_EQ(masked.not_scanned, 0u);
}

TEST(Agreement, requires_two_depths_and_one_sigma) {
  const ComparedImage plain = with_depth({10.0f}), scan = with_depth({10.0f}, {0.1f});
  EXPECT_FALSE(layer_metrics(plain, plain).agreement);
  EXPECT_TRUE(layer_metrics(plain, scan).agreement);
  EXPECT_TRUE(layer_metrics(scan, plain).agreement);
  ComparedImage only_sigma = scan;
  only_sigma.depth.clear();
  EXPECT_FALSE(layer_metrics(plain, only_sigma).agreement);
}

/// Pixels: agrees, differs, not scanned, nothing.
DifferenceMap four_pixels(const ImageMask& mask) {
  return depth_agreement(
      with_depth({10.0f, 10.0f, 10.0f, k_infinity}),
      with_depth({10.0f, 11.0f, k_infinity, k_infinity}, {0.1f, 0.1f, k_infinity, k_infinity}), mask);
}

TEST(AgreementMap, is_green_red_grey_and_black) {
  const Canvas canvas = paint_difference(four_pixels({{1, 1, 1, 1}}));
  const Rgb8 green = canvas.at(0, 0), red = canvas.at(1, 0), grey = canvas.at(2, 0);
  EXPECT_GT(green[1], 2 * green[0]);
  EXPECT_GT(red[0], 2 * red[1]);
  EXPECT_TRUE(grey[0] == grey[1] && grey[1] == grey[2] && grey[0] > 128);
  EXPECT_EQ(canvas.at(3, 0), (Rgb8{0, 0, 0}));
  const Rgb8 excluded = paint_difference(four_pixels({{0, 1, 1, 1}})).at(0, 0);
  for (int x = 0; x < 4; ++x) EXPECT_NE(excluded, canvas.at(x, 0)) << x;
}

TEST(AgreementMap, of_large_images_shows_the_strongest_category_of_each_square) {
  ComparedImage reference = with_depth(std::vector<float>(400 * 300, 10.0f));
  reference.width = 400;
  reference.height = 300;
  ComparedImage test = reference;
  test.depth_sigma.assign(test.pixels(), 0.1f);
  test.depth[151 * 400 + 203] = 12.0f;
  const DifferenceMap map = depth_agreement(reference, test, {});
  const Rgb8 red = map.categories[static_cast<std::size_t>(differs)].color;
  const Font font(find_font());
  for (const int longest_side : {400, 100}) {
    const Canvas canvas = draw_difference(map, font, longest_side);
    int found = 0;
    for (int y = 64; y < 64 + longest_side * 3 / 4; ++y)
      for (int x = 24; x < 24 + longest_side; ++x) found += canvas.at(x, y) == red ? 1 : 0;
    EXPECT_EQ(found, 1) << longest_side;
  }
}

}  // namespace
}  // namespace alidade::test
