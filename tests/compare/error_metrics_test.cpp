// SPDX-License-Identifier: MIT
#include "compare/metrics/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
constexpr double k_infinity = std::numeric_limits<double>::infinity();

// Two pixels of three channels. Differences: 0.25, 0, -0.5, 0.25, 0, 0.
// Sum 0, absolute 1, squares 0.375: rmse sqrt(0.0625) = 0.25, PSNR 20 log10 4.
TEST(ErrorMetrics, figures_are_those_counted_by_hand) {
  const std::vector<float> reference{0.25f, 0.5f, 1.0f, 0.0f, 0.5f, 0.75f};
  const std::vector<float> test{0.5f, 0.5f, 0.5f, 0.25f, 0.5f, 0.75f};
  const ErrorMetrics metrics = error_metrics(reference, test, 3, 2);
  EXPECT_EQ(metrics.values, 6u);
  EXPECT_EQ(metrics.excluded, 0u);
  EXPECT_EQ(metrics.mean, 0.0);
  EXPECT_DOUBLE_EQ(metrics.mean_abs, 1.0 / 6.0);
  EXPECT_EQ(metrics.rmse, 0.25);
  EXPECT_NEAR(metrics.psnr, 12.041199826559248, 1e-12);
  EXPECT_EQ(metrics.max_abs, 0.5);
  EXPECT_EQ(metrics.max_x, 0);
  EXPECT_EQ(metrics.max_y, 0);
  EXPECT_EQ(metrics.max_channel, 2);
  EXPECT_EQ(metrics.percentile_95, 0.5);
}

TEST(ErrorMetrics, equal_images_have_no_error_and_an_infinite_psnr) {
  for (const ColorEncoding encoding : {ColorEncoding::display, ColorEncoding::linear}) {
    const ComparedImage image = patchy_image(20, 10, encoding, "same");
    const ErrorMetrics metrics = error_metrics(image, image, ColorEncoding::display);
    EXPECT_EQ(metrics.values, 600u);
    EXPECT_EQ(metrics.rmse, 0.0);
    EXPECT_EQ(metrics.psnr, k_infinity);
    EXPECT_EQ(metrics.max_abs, 0.0);
    EXPECT_EQ(metrics.max_x, -1);
    EXPECT_EQ(metrics.percentile_95, 0.0);
  }
}

TEST(ErrorMetrics, exchanging_the_images_changes_the_sign_of_the_mean_only) {
  const ComparedImage one = patchy_image(31, 17, ColorEncoding::display, "one");
  const ComparedImage other = patchy_image(31, 17, ColorEncoding::display, "other", 0.5);
  const ErrorMetrics there = error_metrics(one, other, ColorEncoding::linear);
  const ErrorMetrics back = error_metrics(other, one, ColorEncoding::linear);
  EXPECT_NE(there.mean, 0.0);
  EXPECT_EQ(there.mean, -back.mean);
  EXPECT_EQ(there.rmse, back.rmse);
  EXPECT_EQ(there.max_abs, back.max_abs);
  EXPECT_EQ(there.percentile_95, back.percentile_95);
}

// Codes 10 and 13 of 255: the difference is 3 / 255 without a rounding.
TEST(ErrorMetrics, differences_of_codes_are_exact) {
  const auto grey = [](int code) {
    const float value = static_cast<float>(code) / 255.0f;
    ComparedImage image = uniform_image(7, 5, ColorEncoding::display, value, value, value);
    image.largest_code = 255;
    return image;
  };
  const ErrorMetrics metrics = error_metrics(grey(10), grey(13), ColorEncoding::display);
  EXPECT_EQ(metrics.rmse, 3.0 / 255.0);
  EXPECT_EQ(metrics.mean, 3.0 / 255.0);
  EXPECT_EQ(metrics.percentile_95, 3.0 / 255.0);
  // Linear light of the straight part of the curve: divided by 12.92.
  EXPECT_NEAR(error_metrics(grey(0), grey(10), ColorEncoding::linear).rmse, 10.0 / 255.0 / 12.92, 1e-9);
}

TEST(ErrorMetrics, two_grey_images_count_one_channel) {
  ComparedImage grey = uniform_image(4, 4, ColorEncoding::display, 0.5f, 0.5f, 0.5f);
  grey.color_channels = 1;
  EXPECT_EQ(error_metrics(grey, grey, ColorEncoding::display).values, 16u);
  const ComparedImage color = uniform_image(4, 4, ColorEncoding::display, 0.5f, 0.5f, 0.5f);
  EXPECT_EQ(error_metrics(grey, color, ColorEncoding::display).values, 48u);
}

TEST(ErrorMetrics, pixels_that_are_not_finite_are_counted_and_left_out_whole) {
  ComparedImage reference = uniform_image(4, 3, ColorEncoding::linear, 0.25f, 0.25f, 0.25f);
  ComparedImage test = uniform_image(4, 3, ColorEncoding::linear, 0.5f, 0.5f, 0.5f);
  reference.color[3 * 2] = k_nan;
  test.color[3 * 2 + 1] = 99.0f;
  test.color[3 * 7 + 2] = std::numeric_limits<float>::infinity();
  reference.color[3 * 9] = test.color[3 * 9] = std::numeric_limits<float>::infinity();
  for (const ColorEncoding encoding : {ColorEncoding::linear, ColorEncoding::display}) {
    const ErrorMetrics metrics = error_metrics(reference, test, encoding);
    EXPECT_EQ(metrics.excluded, 3u);
    EXPECT_EQ(metrics.values, 27u);
    EXPECT_EQ(metrics.percentile_95, metrics.max_abs);
    if (encoding == ColorEncoding::linear) {
      EXPECT_EQ(metrics.rmse, 0.25);
    }
  }
  const ErrorMetrics plain = error_metrics(reference.color, test.color, 3, 4);
  EXPECT_EQ(plain.excluded, 3u);
  EXPECT_EQ(plain.max_abs, 0.25);
}

TEST(ErrorMetrics, pixels_that_do_not_count_are_neither_compared_nor_excluded) {
  ComparedImage reference = uniform_image(3, 1, ColorEncoding::linear, 0, 0, 0);
  ComparedImage test = uniform_image(3, 1, ColorEncoding::linear, 0.5f, 0.5f, 0.5f);
  test.color[0] = k_nan;
  test.color[3] = 7.0f;
  const ErrorMetrics metrics = error_metrics(reference, test, ColorEncoding::linear, {{0, 0, 1}});
  EXPECT_EQ(metrics.values, 3u);
  EXPECT_EQ(metrics.excluded, 0u);
  EXPECT_EQ(metrics.max_abs, 0.5);
  EXPECT_EQ(metrics.max_x, 2);
  const ErrorMetrics none = error_metrics(reference, test, ColorEncoding::linear, {{0, 0, 0}});
  EXPECT_EQ(none.values, 0u);
  EXPECT_EQ(none.rmse, 0.0);
  EXPECT_TRUE(std::isnan(none.psnr));
}

// Of 40 differences 1 .. 40 the 38th is the first that 95 % do not exceed; of 19 it is the 19th (18.05
// rounded up).
TEST(ErrorMetrics, the_percentile_is_of_the_pixels_that_count) {
  const std::vector<float> reference(40, 0.0f);
  std::vector<float> test(40, 0.125f);
  ImageMask mask;
  mask.counts.assign(40, 1);
  for (std::size_t i = 0; i < 20; ++i) {
    test[i] = 0.0f;
    mask.counts[i] = 0;
  }
  EXPECT_EQ(error_metrics(reference, test, 1, 10, mask).percentile_95, 0.125);
}

TEST(ErrorMetrics, the_percentile_is_that_of_the_nearest_rank) {
  for (const auto& [count, expected] : {std::pair{40, 38.0}, std::pair{20, 19.0}, std::pair{19, 19.0}}) {
    std::vector<float> reference(static_cast<std::size_t>(count), 0.0f), test;
    for (int i = count; i >= 1; --i) test.push_back(static_cast<float>(i % 2 ? i : -i));
    EXPECT_EQ(error_metrics(reference, test, 1, count).percentile_95, expected) << count;
  }
}

TEST(ErrorMetrics, the_same_bytes_on_any_number_of_threads) {
  const ComparedImage one = patchy_image(301, 217, ColorEncoding::linear, "threads");
  const ComparedImage other = patchy_image(301, 217, ColorEncoding::linear, "alone", 0.4);
  const ErrorMetrics expected = error_metrics(one, other, ColorEncoding::linear);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  const ErrorMetrics metrics = error_metrics(one, other, ColorEncoding::linear);
  EXPECT_EQ(metrics.rmse, expected.rmse);
  EXPECT_EQ(metrics.mean, expected.mean);
  EXPECT_EQ(metrics.percentile_95, expected.percentile_95);
}

TEST(ErrorMetrics, images_of_other_sizes_or_without_colour_are_errors) {
  const ComparedImage image = uniform_image(3, 2, ColorEncoding::display, 0, 0, 0);
  EXPECT_THROW(
      error_metrics(image, uniform_image(2, 3, ColorEncoding::display, 0, 0, 0), ColorEncoding::display),
      SizeMismatch);
  ComparedImage layers = image;
  layers.color_channels = 0;
  layers.color.clear();
  EXPECT_THROW(error_metrics(image, layers, ColorEncoding::display), Error);
}

}  // namespace
}  // namespace alidade::test
