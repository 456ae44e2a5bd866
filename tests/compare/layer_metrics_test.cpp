// SPDX-License-Identifier: MIT
#include "compare/metrics/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();
constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();

ComparedImage layers_only(int width) {
  ComparedImage image;
  image.file = "layers";
  image.width = width;
  image.height = 1;
  return image;
}

TEST(LayerMetrics, layers_that_one_image_lacks_are_not_compared) {
  ComparedImage reference = layers_only(1), test = layers_only(1);
  reference.depth = {1.0f};
  reference.ids = test.ids = {3};
  const LayerMetrics metrics = layer_metrics(reference, test);
  EXPECT_FALSE(metrics.depth);
  EXPECT_FALSE(metrics.normals);
  ASSERT_TRUE(metrics.ids);
  EXPECT_EQ(metrics.ids->percent_equal, 100.0);
}

// Differences of the first four pixels: 0, 0.0078125, -0.03125, 0.5 at depths 1, 2, 0.5, 100.
TEST(LayerMetrics, depth_figures_are_those_counted_by_hand) {
  ComparedImage reference = layers_only(8), test = layers_only(8);
  reference.depth = {1.0f, 2.0f, 0.5f, 100.0f, 5.0f, k_infinity, k_nan, 0.0f};
  test.depth = {1.0f, 2.0078125f, 0.46875f, 100.5f, k_infinity, 4.0f, k_infinity, k_infinity};
  const DepthMetrics metrics = *layer_metrics(reference, test).depth;
  EXPECT_EQ(metrics.pixels, 4u);
  EXPECT_EQ(metrics.only_reference, 1u);
  EXPECT_EQ(metrics.only_test, 1u);
  EXPECT_EQ(metrics.invalid, 1u);
  EXPECT_DOUBLE_EQ(metrics.mean, 0.4765625 / 4);
  EXPECT_DOUBLE_EQ(metrics.mean_abs, 0.5390625 / 4);
  EXPECT_DOUBLE_EQ(metrics.rmse, std::sqrt((0.00006103515625 + 0.0009765625 + 0.25) / 4));
  EXPECT_EQ(metrics.max_abs, 0.5);
  EXPECT_EQ(metrics.max_x, 3);
  EXPECT_EQ(metrics.max_y, 0);
  EXPECT_EQ(metrics.percentile_95, 0.5);
  EXPECT_DOUBLE_EQ(metrics.mean_relative, (0.00390625 + 0.0625 + 0.005) / 4);
  EXPECT_EQ(metrics.percent_within_1_cm, 50.0);
  EXPECT_EQ(metrics.percent_within_5_cm, 75.0);
  EXPECT_EQ(metrics.percent_within_1_percent, 75.0);
  const DepthMetrics masked = *layer_metrics(reference, test, {{1, 1, 0, 0, 0, 0, 0, 0}}).depth;
  EXPECT_EQ(masked.pixels, 2u);
  EXPECT_EQ(masked.max_abs, 0.0078125);
  EXPECT_EQ(masked.percentile_95, 0.0078125);
}

TEST(LayerMetrics, angles_between_normals_do_not_depend_on_their_lengths) {
  ComparedImage reference = layers_only(5), test = layers_only(5);
  reference.normals = {0, 0, 1, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 1};
  test.normals = {0, 0, 1, 3, 3, 0, 0, -1, 0, 0, 0, 1, 0, 0, 0};
  const NormalMetrics metrics = *layer_metrics(reference, test).normals;
  EXPECT_EQ(metrics.pixels, 3u);
  EXPECT_EQ(metrics.only_reference, 1u);
  EXPECT_EQ(metrics.only_test, 1u);
  EXPECT_NEAR(metrics.mean, (0.0 + 45.0 + 180.0) / 3.0, 1e-12);
  EXPECT_NEAR(metrics.max, 180.0, 1e-12);
  EXPECT_EQ(metrics.max_x, 2);
  EXPECT_NEAR(metrics.percentile_95, 180.0, 1e-5);
}

TEST(LayerMetrics, numbers_that_are_no_depth_normal_or_alpha_are_counted) {
  ComparedImage reference = layers_only(4), test = layers_only(4);
  reference.depth = {-1.0f, k_nan, 2.0f, k_infinity};
  test.depth = {1.0f, 1.0f, -k_infinity, 0.0f};
  reference.normals = {0, 0, 1, k_nan, 0, 1, 0, 0, 0, 0, 0, 1};
  test.normals = {0, 0, 1, 0, 0, 1, 0, 0, 0, 0, k_infinity, 1};
  reference.alpha = {1.0f, k_nan, 1.0f, 0.0f};
  test.alpha = {1.0f, 1.0f, k_infinity, 0.5f};
  const LayerMetrics metrics = layer_metrics(reference, test);
  EXPECT_EQ(metrics.depth->invalid, 3u);
  EXPECT_EQ(metrics.depth->only_test, 2u);
  EXPECT_EQ(metrics.depth->only_reference, 1u);
  EXPECT_EQ(metrics.normals->invalid, 2u);
  EXPECT_EQ(metrics.normals->pixels, 1u);
  EXPECT_EQ(metrics.alpha->invalid, 2u);
  EXPECT_EQ(metrics.alpha->pixels, 2u);
  EXPECT_EQ(metrics.alpha->mean_abs, 0.25);
  EXPECT_EQ(metrics.alpha->max_x, 3);
}

// Rows are summed up in blocks of 16: the largest difference is below the first block, and the first of two
// equal ones counts.
TEST(LayerMetrics, figures_of_many_rows_are_those_of_all_of_them) {
  ComparedImage reference = layers_only(3), test = layers_only(3);
  reference.height = test.height = 40;
  reference.depth.assign(120, 10.0f);
  reference.normals.resize(360);
  for (std::size_t i = 0; i < 120; ++i) reference.normals[3 * i] = 1.0f;
  reference.ids.assign(120, 1);
  test.depth = reference.depth;
  test.normals = reference.normals;
  test.ids = reference.ids;
  for (const std::size_t pixel : {5u, 3u * 20 + 1, 3u * 35 + 2}) {
    test.depth[pixel] = pixel == 5 ? 10.5f : 12.0f;
    test.normals[3 * pixel + 1] = pixel == 5 ? 1.0f : 1e9f;
    test.ids[pixel] = 2;
  }
  const LayerMetrics metrics = layer_metrics(reference, test);
  EXPECT_EQ(metrics.depth->pixels, 120u);
  EXPECT_DOUBLE_EQ(metrics.depth->mean, 4.5 / 120);
  EXPECT_EQ(metrics.depth->max_x, 1);
  EXPECT_EQ(metrics.depth->max_y, 20);
  EXPECT_DOUBLE_EQ(metrics.depth->percent_within_5_cm, 97.5);
  EXPECT_NEAR(metrics.normals->mean, (45.0 + 90.0 + 90.0) / 120, 1e-6);
  EXPECT_EQ(metrics.normals->max_y, 20);
  EXPECT_EQ(metrics.ids->equal, 117u);
}

TEST(LayerMetrics, ids_count_where_at_least_one_image_sees_something) {
  ComparedImage reference = layers_only(5), test = layers_only(5);
  reference.ids = {0, 7, 8, 0, 4294967295u};
  test.ids = {0, 7, 9, 3, 4294967295u};
  const IdMetrics metrics = *layer_metrics(reference, test).ids;
  EXPECT_EQ(metrics.pixels, 4u);
  EXPECT_EQ(metrics.equal, 2u);
  EXPECT_EQ(metrics.percent_equal, 50.0);
}

TEST(LayerMetrics, layers_of_which_nothing_counts_give_zeros) {
  ComparedImage reference = layers_only(2);
  reference.depth = {1.0f, 2.0f};
  reference.normals.assign(6, 1.0f);
  reference.ids = {1, 2};
  const LayerMetrics metrics = layer_metrics(reference, reference, {{0, 0}});
  EXPECT_EQ(metrics.depth->pixels, 0u);
  EXPECT_EQ(metrics.depth->percentile_95, 0.0);
  EXPECT_EQ(metrics.depth->rmse, 0.0);
  EXPECT_EQ(metrics.normals->mean, 0.0);
  EXPECT_EQ(metrics.ids->percent_equal, 0.0);
}

}  // namespace
}  // namespace alidade::test
