// SPDX-License-Identifier: MIT
#include "compare/metrics/ssim.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

/// One channel of an image.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;
  double at(int x, int y) const { return values[static_cast<std::size_t>(y * width + x)]; }
};

Plane plane_of(const ComparedImage& image, int channel) {
  Plane plane{image.width, image.height, {}};
  for (std::size_t i = 0; i < image.pixels(); ++i)
    plane.values.push_back(image.color[3 * i + static_cast<std::size_t>(channel)]);
  return plane;
}

struct PlainMeans {
  double similarity = 0.0, contrast = 0.0;
};

/// SSIM as the paper defines it: whole windows of 11 x 11, and variances as means of squared distances from
/// the mean.
PlainMeans plain_ssim(const Plane& one, const Plane& other) {
  PlainMeans means;
  double weights = 0.0;
  const auto weight = [](int dx, int dy) { return std::exp(-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)); };
  const auto over_window = [&](const auto& work) {
    for (int dy = -5; dy <= 5; ++dy)
      for (int dx = -5; dx <= 5; ++dx) work(dx, dy, weight(dx, dy));
  };
  over_window([&](int, int, double w) { weights += w; });
  int count = 0;
  for (int y = 5; y < one.height - 5; ++y) {
    for (int x = 5; x < one.width - 5; ++x, ++count) {
      double mean_one = 0.0, mean_other = 0.0, one_squares = 0.0, other_squares = 0.0, products = 0.0;
      over_window([&](int dx, int dy, double w) {
        mean_one += w / weights * one.at(x + dx, y + dy);
        mean_other += w / weights * other.at(x + dx, y + dy);
      });
      over_window([&](int dx, int dy, double w) {
        const double a = one.at(x + dx, y + dy) - mean_one, b = other.at(x + dx, y + dy) - mean_other;
        one_squares += w / weights * a * a;
        other_squares += w / weights * b * b;
        products += w / weights * a * b;
      });
      const double contrast = (2.0 * products + 0.0009) / (one_squares + other_squares + 0.0009);
      means.contrast += contrast;
      means.similarity += contrast * (2.0 * mean_one * mean_other + 0.0001) /
                          (mean_one * mean_one + mean_other * mean_other + 0.0001);
    }
  }
  return {means.similarity / count, means.contrast / count};
}

Plane half(const Plane& plane) {
  Plane small{(plane.width + 1) / 2, (plane.height + 1) / 2, {}};
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      const int right = std::min(2 * x + 1, plane.width - 1), below = std::min(2 * y + 1, plane.height - 1);
      small.values.push_back((plane.at(2 * x, 2 * y) + plane.at(right, 2 * y) + plane.at(2 * x, below) +
                              plane.at(right, below)) /
                             4.0);
    }
  }
  return small;
}

TEST(Ssim, equal_images_give_one) {
  const ComparedImage image = patchy_image(171, 165, ColorEncoding::display, "equal");
  const Similarity result = similarity(image, image);
  EXPECT_NEAR(result.ssim, 1.0, 1e-12);
  EXPECT_NEAR(result.ms_ssim, 1.0, 1e-12);
}

TEST(Ssim, exchanging_the_images_changes_nothing) {
  const ComparedImage one = patchy_image(181, 170, ColorEncoding::display, "one");
  const ComparedImage other = patchy_image(181, 170, ColorEncoding::display, "other", 0.5);
  const Similarity there = similarity(one, other), back = similarity(other, one);
  EXPECT_EQ(there.ssim, back.ssim);
  EXPECT_EQ(there.ms_ssim, back.ms_ssim);
}

// Without contrast only the means are left: (2 a b + C1) / (a^2 + b^2 + C1) with C1 = 0.0001.
TEST(Ssim, images_of_one_colour_give_what_the_paper_says) {
  const ComparedImage one = uniform_image(30, 20, ColorEncoding::display, 0.5f, 0.25f, 1.0f);
  const ComparedImage other = uniform_image(30, 20, ColorEncoding::display, 0.25f, 0.25f, 0.0f);
  const double expected = (0.2501 / 0.3126 + 1.0 + 0.0001 / 1.0001) / 3.0;
  EXPECT_NEAR(similarity(one, other).ssim, expected, 1e-9);
}

// Such images have equal contrast at all scales, and other means count at the last one only.
TEST(Ssim, five_scales_see_other_means_at_the_last_one) {
  const ComparedImage one = uniform_image(170, 165, ColorEncoding::display, 0.5f, 0.25f, 1.0f);
  const ComparedImage other = uniform_image(170, 165, ColorEncoding::display, 0.25f, 0.25f, 0.0f);
  const double expected = (std::pow(0.2501 / 0.3126, 0.1333) + 1.0 + std::pow(0.0001 / 1.0001, 0.1333)) / 3.0;
  EXPECT_NEAR(similarity(one, other).ms_ssim, expected, 1e-9);
}

TEST(Ssim, means_are_those_of_plain_loops) {
  // More than one tile each way.
  const ComparedImage one = patchy_image(143, 81, ColorEncoding::display, "plain", 0.2);
  const ComparedImage other = patchy_image(143, 81, ColorEncoding::display, "simple", 0.6);
  double expected = 0.0;
  for (int channel = 0; channel < 3; ++channel)
    expected += plain_ssim(plane_of(one, channel), plane_of(other, channel)).similarity / 3.0;
  EXPECT_LT(expected, 0.95);
  EXPECT_NEAR(similarity(one, other).ssim, expected, 1e-9);
}

TEST(Ssim, five_scales_are_those_of_plain_loops) {
  const ComparedImage one = patchy_image(163, 161, ColorEncoding::display, "scales", 0.3);
  const ComparedImage other = patchy_image(163, 161, ColorEncoding::display, "halves", 0.7);
  constexpr double k_weights[] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  double expected = 0.0;
  for (int channel = 0; channel < 3; ++channel) {
    Plane a = plane_of(one, channel), b = plane_of(other, channel);
    double product = 1.0;
    for (int scale = 0; scale < 5; ++scale) {
      const PlainMeans means = plain_ssim(a, b);
      product *= std::pow(scale == 4 ? means.similarity : means.contrast, k_weights[scale]);
      a = half(a);
      b = half(b);
    }
    expected += product / 3.0;
  }
  EXPECT_LT(expected, 0.98);
  EXPECT_NEAR(similarity(one, other).ms_ssim, expected, 1e-6);
}

TEST(Ssim, images_too_small_for_the_window_give_no_number) {
  const ComparedImage narrow = patchy_image(10, 40, ColorEncoding::display, "narrow");
  EXPECT_TRUE(std::isnan(similarity(narrow, narrow).ssim));
  const ComparedImage pixel = patchy_image(1, 1, ColorEncoding::display, "pixel");
  EXPECT_TRUE(std::isnan(similarity(pixel, pixel).ssim));
  const ComparedImage small = patchy_image(200, 160, ColorEncoding::display, "small");
  EXPECT_TRUE(std::isnan(similarity(small, small).ms_ssim));
}

TEST(Ssim, pixels_that_do_not_count_make_no_difference) {
  const ComparedImage reference = patchy_image(170, 165, ColorEncoding::linear, "mask");
  ComparedImage test = patchy_image(170, 165, ColorEncoding::linear, "hidden", 0.4);
  ImageMask mask;
  // Not the middle, which the only window of the smallest scale is about.
  const image::PixelBox hidden{100, 30, 150, 70};
  ignore_rectangles(mask, reference, std::span(&hidden, 1));
  const Similarity before = similarity(reference, test, mask);
  for (int y = hidden.top; y < hidden.bottom; ++y)
    for (int i = 3 * hidden.left; i < 3 * hidden.right; ++i)
      test.color[static_cast<std::size_t>(510 * y + i)] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(similarity(reference, test, mask).ssim, before.ssim);
  EXPECT_EQ(similarity(reference, test, mask).ms_ssim, before.ms_ssim);
  EXPECT_EQ(similarity(reference, test).ssim, before.ssim);
  EXPECT_LT(before.ssim, 1.0);
  mask.counts.assign(reference.pixels(), 0);
  EXPECT_TRUE(std::isnan(similarity(reference, test, mask).ssim));
  EXPECT_TRUE(std::isnan(similarity(reference, test, mask).ms_ssim));
}

TEST(Ssim, a_pixel_of_half_size_counts_if_all_four_of_its_pixels_do) {
  const ComparedImage image = patchy_image(162, 162, ColorEncoding::display, "one of four");
  for (int part = 0; part < 4; ++part) {
    ImageMask mask;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) mask.counts.push_back(x % 2 != part % 2 || y % 2 != part / 2);
    const Similarity result = similarity(image, image, mask);
    EXPECT_NEAR(result.ssim, 1.0, 1e-12) << part;
    EXPECT_TRUE(std::isnan(result.ms_ssim)) << part;
  }
}

TEST(Ssim, the_same_bytes_on_any_number_of_threads) {
  const ComparedImage one = patchy_image(300, 200, ColorEncoding::linear, "threads");
  const ComparedImage other = patchy_image(300, 200, ColorEncoding::linear, "alone", 0.4);
  const Similarity expected = similarity(one, other);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  const Similarity result = similarity(one, other);
  EXPECT_EQ(result.ssim, expected.ssim);
  EXPECT_EQ(result.ms_ssim, expected.ms_ssim);
}

}  // namespace
}  // namespace alidade::test
