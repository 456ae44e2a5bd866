// SPDX-License-Identifier: MIT
#include "compare/photographs/color_match.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

constexpr glm::dvec3 k_scale(0.7, 1.1, 1.6), k_offset(0.02, 0.0, -0.01);

/// Light of a scene.
std::array<double, 3> light_at(int x, int y) {
  return {0.05 + 0.4 * blots(x, y, 1), 0.05 + 0.4 * blots(x, y, 20), 0.05 + 0.4 * blots(x, y, 40)};
}

ComparedImage scene() {
  return draw_image(300, 200, ColorEncoding::linear, light_at);
}

/// scene() by a camera of other colours: scene = scale * this + offset.
ComparedImage by_another_camera(const glm::dvec3& scale, const glm::dvec3& offset) {
  return draw_image(300, 200, ColorEncoding::linear, [&](int x, int y) {
    std::array<double, 3> light = light_at(x, y);
    for (int channel = 0; channel < 3; ++channel) {
      auto& value = light[static_cast<std::size_t>(channel)];
      value = (value - offset[channel]) / scale[channel];
    }
    return light;
  });
}

void expect_match(const std::optional<ColorMatch>& match, const glm::dvec3& scale, const glm::dvec3& offset,
                  double tolerance) {
  ASSERT_TRUE(match);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(match->scale[channel], scale[channel], tolerance) << channel;
    EXPECT_NEAR(match->offset[channel], offset[channel], tolerance) << channel;
  }
}

void set_pixel(ComparedImage& image, std::size_t pixel, float value) {
  for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) image.color[i] = value;
}

TEST(ColorMatch, exposure_and_white_balance_are_found_per_channel) {
  const std::optional<ColorMatch> match =
      match_color(scene(), by_another_camera(k_scale, glm::dvec3(0.0)), {}, ColorModel::exposure);
  expect_match(match, k_scale, glm::dvec3(0.0), 1e-5);
  EXPECT_EQ(match->inliers, 1.0);
}

TEST(ColorMatch, affine_finds_offsets_too) {
  expect_match(match_color(scene(), by_another_camera(k_scale, k_offset), {}, ColorModel::affine), k_scale,
               k_offset, 1e-5);
}

TEST(ColorMatch, equal_images_need_nothing) {
  for (const ColorModel model : {ColorModel::exposure, ColorModel::affine})
    expect_match(match_color(scene(), scene(), {}, model), glm::dvec3(1.0), glm::dvec3(0.0), 1e-9);
}

TEST(ColorMatch, two_fifths_of_the_image_may_show_something_else) {
  ComparedImage test = by_another_camera(k_scale, k_offset);
  for (std::size_t pixel = 0; pixel < test.pixels() * 2 / 5; ++pixel) set_pixel(test, pixel, 0.9f);
  const std::optional<ColorMatch> match = match_color(scene(), test, {}, ColorModel::affine);
  expect_match(match, k_scale, k_offset, 1e-4);
  EXPECT_NEAR(match->inliers, 0.6, 0.02);
}

TEST(ColorMatch, noise_and_a_few_pixels_of_misalignment_cost_little) {
  ComparedImage test = by_another_camera(k_scale, k_offset);
  ComparedImage moved = test;
  for (std::size_t pixel = 0; pixel + 2 < test.pixels(); ++pixel) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto noise = static_cast<float>(0.1 * (hashed(3 * pixel + i) - 0.5));
      moved.color[3 * pixel + i] = test.color[3 * (pixel + 2) + i] + noise;
    }
  }
  expect_match(match_color(scene(), moved, {}, ColorModel::exposure), {0.74, 1.1, 1.57}, glm::dvec3(0.0),
               0.05);
  expect_match(match_color(scene(), moved, {}, ColorModel::affine), k_scale, k_offset, 0.1);
}

TEST(ColorMatch, display_encoded_images_are_fitted_in_linear_light_without_clipped_pixels) {
  ComparedImage reference = scene(), test = by_another_camera(glm::dvec3(0.25), glm::dvec3(0.0));
  for (ComparedImage* const image : {&reference, &test}) {
    image->color = display_color(*image);
    image->encoding = ColorEncoding::display;
  }
  // Four times as bright: a good part of it is white.
  std::size_t white = 0;
  for (const float value : test.color) white += value == 1.0f;
  EXPECT_GT(white, test.color.size() / 20);
  expect_match(match_color(reference, test, {}, ColorModel::exposure), glm::dvec3(0.25), glm::dvec3(0.0),
               1e-4);
}

TEST(ColorMatch, of_display_codes_the_first_and_last_two_are_clipped) {
  // One channel has the same code everywhere, so all pixels count or none.
  const auto with_code = [](int code) {
    return draw_image(64, 64, ColorEncoding::display, [code](int x, int y) {
      return std::array<double, 3>{(60 + x) / 255.0, (60 + y) / 255.0, code / 255.0};
    });
  };
  for (const ColorModel model : {ColorModel::exposure, ColorModel::affine}) {
    for (const int code : {0, 1, 254, 255})
      EXPECT_FALSE(match_color(with_code(128), with_code(code), {}, model)) << code;
  }
  for (const int code : {2, 253}) {
    const auto match = match_color(with_code(code), with_code(code), {}, ColorModel::exposure);
    expect_match(match, glm::dvec3(1.0), glm::dvec3(0.0), 1e-9);
  }
}

TEST(ColorMatch, pixels_that_do_not_count_play_no_role) {
  const ComparedImage reference = scene();
  ComparedImage test = by_another_camera(k_scale, glm::dvec3(0.0));
  ImageMask mask;
  mask.counts.assign(test.pixels(), 1);
  test.alpha.assign(test.pixels(), 1.0f);
  test.depth.assign(test.pixels(), 1.0f);
  // Three quarters of the image are wrong, more than robustness bears.
  for (std::size_t pixel = 0; pixel < test.pixels(); ++pixel) {
    const std::size_t row = pixel / 300;
    if (row >= 150) continue;
    set_pixel(test, pixel, 0.5f);
    if (row < 40)
      mask.counts[pixel] = 0;
    else if (row < 80)
      test.alpha[pixel] = 0.0f;
    else if (row < 110)
      test.depth[pixel] = std::numeric_limits<float>::infinity();
    else
      set_pixel(test, pixel, std::numeric_limits<float>::quiet_NaN());
  }
  expect_match(match_color(reference, test, mask, ColorModel::exposure), k_scale, glm::dvec3(0.0), 1e-4);
}

TEST(ColorMatch, what_is_undetermined_is_not_reported) {
  const auto even = [](double value) {
    return draw_image(60, 60, ColorEncoding::linear, [=](int, int) {
      return std::array<double, 3>{value, value, value};
    });
  };
  EXPECT_FALSE(match_color(even(0.5), even(0.0), {}, ColorModel::exposure));
  EXPECT_FALSE(match_color(even(0.5), even(0.25), {}, ColorModel::affine));
  expect_match(match_color(even(0.5), even(0.25), {}, ColorModel::exposure), glm::dvec3(2.0), glm::dvec3(0.0),
               1e-9);
  ImageMask none;
  none.counts.assign(3600, 0);
  EXPECT_FALSE(match_color(even(0.5), even(0.25), none, ColorModel::exposure));
  const ComparedImage small = draw_image(3, 5, ColorEncoding::linear, light_at);
  EXPECT_FALSE(match_color(small, small, {}, ColorModel::exposure));
  EXPECT_THROW(match_color(even(0.5), small, {}, ColorModel::exposure), SizeMismatch);
}

TEST(ColorMatch, applied_it_makes_the_test_equal_to_the_reference) {
  for (const ColorEncoding encoding : {ColorEncoding::linear, ColorEncoding::display}) {
    ComparedImage reference = scene(), test = by_another_camera(k_scale, k_offset);
    if (encoding == ColorEncoding::display) {
      for (ComparedImage* const image : {&reference, &test}) {
        image->color = display_color(*image);
        image->encoding = encoding;
      }
    }
    const std::optional<ColorMatch> match = match_color(reference, test, {}, ColorModel::affine);
    ASSERT_TRUE(match);
    apply_color_match(test, *match);
    for (std::size_t i = 0; i < test.color.size(); ++i)
      ASSERT_NEAR(test.color[i], reference.color[i], 1e-4) << i;
  }
}

TEST(ColorMatch, applied_to_display_encoded_images_it_stays_between_black_and_white) {
  ComparedImage image = draw_image(2, 1, ColorEncoding::display, [](int x, int) {
    return std::array<double, 3>{1.0 * x, 0.5, 0.5};
  });
  apply_color_match(image, {.scale = {3.0, 3.0, 0.0}, .offset = {-0.5, 0.5, 0.0}});
  EXPECT_EQ(image.color, (std::vector<float>{0.0f, 1.0f, 0.0f, 1.0f, 1.0f, 0.0f}));
}

TEST(ColorMatch, is_the_same_on_any_number_of_threads) {
  const ComparedImage reference = scene(), test = by_another_camera(k_scale, k_offset);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::optional<ColorMatch> alone = match_color(reference, test, {}, ColorModel::affine);
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  const std::optional<ColorMatch> together = match_color(reference, test, {}, ColorModel::affine);
  ASSERT_TRUE(alone && together);
  EXPECT_EQ(alone->scale, together->scale);
  EXPECT_EQ(alone->offset, together->offset);
}

TEST(RobustLine, wrong_pairs_up_to_two_fifths_do_not_bend_it) {
  std::vector<FitPair> pairs;
  for (int i = 0; i < 500; ++i) {
    const double x = hashed(static_cast<std::uint64_t>(i));
    const bool is_wrong = i % 5 < 2;
    pairs.push_back({x, is_wrong
                            ? 3.0 - x
                            : 2.0 * x + 0.5 + 0.01 * (hashed(900u + static_cast<std::uint64_t>(i)) - 0.5)});
  }
  const std::optional<RobustLine> line = fit_robust_line(pairs, LineKind::free);
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->scale, 2.0, 0.01);
  EXPECT_NEAR(line->offset, 0.5, 0.01);
  EXPECT_NEAR(line->inliers, 0.6, 0.03);
}

TEST(RobustLine, too_few_pairs_and_pairs_of_one_x_give_no_line) {
  EXPECT_FALSE(fit_robust_line({}, LineKind::free));
  const std::vector<FitPair> three = {{0, 0}, {1, 1}, {2, 2}};
  EXPECT_FALSE(fit_robust_line(three, LineKind::free));
  const std::vector<FitPair> same(10, {1.0, 2.0}), zero(10, {0.0, 2.0}), none(10, {0.0, 0.0});
  EXPECT_FALSE(fit_robust_line(same, LineKind::free));
  EXPECT_FALSE(fit_robust_line(zero, LineKind::through_zero));
  EXPECT_FALSE(fit_robust_line(none, LineKind::through_zero));
  EXPECT_EQ(fit_robust_line(same, LineKind::through_zero)->scale, 2.0);
}

}  // namespace
}  // namespace alidade::test
