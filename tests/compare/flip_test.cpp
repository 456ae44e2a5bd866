// SPDX-License-Identifier: MIT
#include "compare/metrics/flip.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <glm/vec3.hpp>
#include <limits>

#include "compare/metrics/flip_tile.h"
#include "tests/compare/drawn_images.h"
#include "tests/compare/plain_flip.h"

namespace alidade::test {

using namespace compare;

namespace {

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
constexpr float k_infinity = std::numeric_limits<float>::infinity();

double flip_of_uniform(ColorEncoding encoding, glm::vec3 one, glm::vec3 other) {
  const auto image = [&](glm::vec3 color) {
    return uniform_image(23, 17, encoding, color.r, color.g, color.b);
  };
  FlipOptions options;
  options.range = FlipRange::display;
  const FlipResult result = flip(image(one), image(other), {}, options);
  EXPECT_NEAR(result.min, result.max, 1e-5);
  EXPECT_NEAR(result.weighted_median, result.mean, 1e-5);
  return result.mean;
}

// Filters do not change an image of one colour, and it has no features. What is left is HyAB^0.7 of the
// colours, redistributed: below 0.4 of the largest, 41.2761, proportional with 0.95 at the knee, 16.5105.
TEST(Flip, images_of_one_colour_give_what_the_paper_says) {
  // Black and white differ by 100 in lightness: 100^0.7 = 25.1189; 0.95 + 0.05 (25.1189 - 16.5105) / 24.7657.
  EXPECT_NEAR(flip_of_uniform(ColorEncoding::linear, {0, 0, 0}, {1, 1, 1}), 0.967380, 2e-5);
  // The largest difference there is, by definition.
  EXPECT_NEAR(flip_of_uniform(ColorEncoding::linear, {0, 1, 0}, {0, 0, 1}), 1.0, 1e-6);
  // L* of 0.2 and 0.25 is 51.8372 and 57.0754: 5.2382^0.7 = 3.187337, times 0.95 / 16.5105.
  EXPECT_NEAR(flip_of_uniform(ColorEncoding::linear, {0.2f, 0.2f, 0.2f}, {0.25f, 0.25f, 0.25f}), 0.183397,
              2e-5);
  // The sRGB code 188 is 0.502886 of linear light.
  EXPECT_NEAR(flip_of_uniform(ColorEncoding::display, {188 / 255.0f, 188 / 255.0f, 188 / 255.0f}, {0, 0, 0}),
              flip_of_uniform(ColorEncoding::linear, {0.5028865f, 0.5028865f, 0.5028865f}, {0, 0, 0}), 1e-6);
}

TEST(Flip, equal_images_give_exactly_zero) {
  for (const ColorEncoding encoding : {ColorEncoding::display, ColorEncoding::linear}) {
    const ComparedImage image = patchy_image(61, 47, encoding, "equal");
    const FlipResult result = flip(image, image);
    EXPECT_EQ(result.mean, 0.0);
    EXPECT_EQ(result.max, 0.0);
    EXPECT_EQ(result.weighted_third_quartile, 0.0);
    EXPECT_EQ(result.exposures > 0, encoding == ColorEncoding::linear);
  }
}

TEST(Flip, the_map_is_symmetric_in_display_range) {
  const ComparedImage one = patchy_image(70, 33, ColorEncoding::display, "one", 0.2);
  const ComparedImage other = patchy_image(70, 33, ColorEncoding::display, "other", 0.3);
  const FlipResult there = flip(one, other), back = flip(other, one);
  EXPECT_GT(there.mean, 0.01);
  EXPECT_EQ(there.map, back.map);
}

void expect_plain_map(int width, int height, double pixels_per_degree) {
  SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height) + " at " +
               std::to_string(pixels_per_degree));
  ComparedImage one = patchy_image(width, height, ColorEncoding::linear, "plain", 0.2);
  ComparedImage other = patchy_image(width, height, ColorEncoding::linear, "simple", 0.3);
  for (float& value : other.color) value *= 0.9f;
  FlipOptions options;
  options.range = FlipRange::display;
  options.pixels_per_degree = pixels_per_degree;
  const FlipResult result = flip(one, other, {}, options);
  const auto clamped = [](const ComparedImage& image) {
    std::vector<double> values;
    for (const float value : image.color) values.push_back(std::clamp(static_cast<double>(value), 0.0, 1.0));
    return values;
  };
  const std::vector<double> expected =
      PlainFlip(width, height, pixels_per_degree).map(clamped(one), clamped(other));
  double sum = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(result.map[i], expected[i], 2e-4) << "pixel " << i;
    sum += expected[i];
  }
  // Rounding errors of a single pixel have no others to cancel them.
  const double tolerance = expected.size() == 1 ? 2e-4 : 1e-5;
  EXPECT_NEAR(result.mean, sum / static_cast<double>(expected.size()), tolerance);
}

TEST(Flip, maps_are_those_of_plain_loops_in_double_at_any_size_and_distance) {
  expect_plain_map(37, 29, 67.0206);
  expect_plain_map(37, 29, 20.0);
  expect_plain_map(9, 31, 1.0);
  expect_plain_map(13, 1, 140.0);
  expect_plain_map(1, 1, 67.0206);
  // More than one tile each way.
  expect_plain_map(261, 101, 12.0);
}

TEST(Flip, the_same_bytes_on_any_number_of_threads_and_instruction_set) {
  const ComparedImage one = patchy_image(530, 210, ColorEncoding::linear, "threads", 0.2);
  const ComparedImage other = patchy_image(530, 210, ColorEncoding::linear, "lanes", 0.2);
  FlipOptions options;
  const FlipResult expected = flip(one, other);
  {
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    const FlipResult result = flip(one, other);
    EXPECT_EQ(result.map, expected.map);
    EXPECT_EQ(result.mean, expected.mean);
    EXPECT_EQ(result.weighted_median, expected.weighted_median);
  }
  for (const InstructionSet set : available_instruction_sets()) {
    options.instruction_set = set;
    EXPECT_EQ(flip(one, other, {}, options).map, expected.map) << name(set);
  }
}

TEST(Flip, weighted_quantiles_are_the_first_values_beyond_their_share_of_the_sum) {
  const ComparedImage one = patchy_image(64, 50, ColorEncoding::display, "quantile", 0.2);
  const ComparedImage other = patchy_image(64, 50, ColorEncoding::display, "median", 0.4);
  const FlipResult result = flip(one, other);
  std::vector<float> sorted = result.map;
  std::ranges::sort(sorted);
  double sum = 0.0;
  for (const float value : sorted) sum += value;
  const auto quantile = [&](double share) {
    double running = 0.0;
    for (const float value : sorted)
      if ((running += value) > share * sum) return value;
    return 0.0f;
  };
  EXPECT_EQ(result.weighted_first_quartile, quantile(0.25));
  EXPECT_EQ(result.weighted_median, quantile(0.5));
  EXPECT_EQ(result.weighted_third_quartile, quantile(0.75));
  EXPECT_EQ(result.min, sorted.front());
  EXPECT_EQ(result.max, sorted.back());
  EXPECT_NEAR(result.mean, sum / static_cast<double>(sorted.size()), 1e-12);
}

TEST(Flip, pixels_that_do_not_count_make_no_difference) {
  const ComparedImage reference = patchy_image(60, 40, ColorEncoding::display, "mask", 0.2);
  ComparedImage test = patchy_image(60, 40, ColorEncoding::display, "hidden", 0.3);
  ImageMask mask;
  const image::PixelBox hidden{20, 10, 45, 30};
  ignore_rectangles(mask, reference, std::span(&hidden, 1));
  const FlipResult before = flip(reference, test, mask);
  for (int y = hidden.top; y < hidden.bottom; ++y)
    for (int i = 3 * hidden.left; i < 3 * hidden.right; ++i)
      test.color[static_cast<std::size_t>(180 * y + i)] = 1.0f;
  const FlipResult after = flip(reference, test, mask);
  EXPECT_EQ(before.map, after.map);
  EXPECT_EQ(before.mean, after.mean);
  EXPECT_EQ(before.map[20 * 60 + 30], 0.0f);
  EXPECT_GT(before.min, 0.0);
  double sum = 0.0;
  for (const float value : before.map) sum += value;
  EXPECT_NEAR(before.mean, sum / (60 * 40 - 25 * 20), 1e-12);
  mask.counts.assign(60 * 40, 0);
  EXPECT_EQ(flip(reference, test, mask).mean, 0.0);
}

TEST(Flip, pixels_that_are_not_finite_do_not_count_and_spoil_nothing) {
  ComparedImage reference = patchy_image(40, 30, ColorEncoding::linear, "nan");
  ComparedImage test = patchy_image(40, 30, ColorEncoding::linear, "nothing");
  reference.color[3 * 50] = k_nan;
  test.color[3 * 60 + 1] = k_infinity;
  reference.color[3 * 70 + 2] = test.color[3 * 70 + 2] = -k_infinity;
  const FlipResult result = flip(reference, test);
  for (const float value : result.map) EXPECT_TRUE(value >= 0.0f && value <= 1.0f);
  for (const std::size_t pixel : {50u, 60u, 70u}) EXPECT_EQ(result.map[pixel], 0.0f);
  EXPECT_GT(result.mean, 0.0);
}

TEST(HdrFlip, exposures_run_from_the_brightest_to_the_median_pixel) {
  // Luminances 0.5, 1, 2 and 8 in equal parts: the upper median is 2. ACES reaches 0.85 at 2.118872.
  ComparedImage image = uniform_image(4, 1, ColorEncoding::linear, 0.5f, 0.5f, 0.5f);
  for (std::size_t i = 0; i < 3; ++i) {
    image.color[3 + i] = 1.0f;
    image.color[6 + i] = 2.0f;
    image.color[9 + i] = 8.0f;
  }
  const auto range_of = [&](ToneMapper mapper) {
    FlipOptions options;
    options.tone_mapper = mapper;
    return exposure_range(image, image, {}, options);
  };
  const ExposureRange range = range_of(ToneMapper::aces);
  EXPECT_NEAR(range.start, std::log2(2.118872 / 8.0), 1e-6);
  EXPECT_NEAR(range.stop, std::log2(2.118872 / 2.0), 1e-6);
  EXPECT_EQ(range.count, 2);
  EXPECT_EQ(range.exposure(0), range.start);
  EXPECT_EQ(range.exposure(1), range.stop);
  EXPECT_NEAR(range_of(ToneMapper::hable).stop, std::log2(3.127750 / 2.0), 1e-6);
  EXPECT_NEAR(range_of(ToneMapper::reinhard).stop, std::log2(5.666667 / 2.0), 1e-6);
}

TEST(HdrFlip, the_map_is_the_largest_of_those_of_its_exposures) {
  const ComparedImage one = patchy_image(41, 23, ColorEncoding::linear, "exposed", 0.2);
  const ComparedImage other = patchy_image(41, 23, ColorEncoding::linear, "dark", 0.4);
  for (const ToneMapper mapper : {ToneMapper::aces, ToneMapper::hable, ToneMapper::reinhard}) {
    FlipOptions options;
    options.tone_mapper = mapper;
    options.start_exposure = -2.0;
    options.stop_exposure = 1.0;
    options.exposures = 3;
    const FlipResult result = flip(one, other, {}, options);
    std::vector<double> expected(one.pixels(), 0.0);
    for (const double exposure : {-2.0, -0.5, 1.0}) {
      const auto toned = [&](const ComparedImage& image) {
        std::vector<double> values;
        for (std::size_t i = 0; i < image.color.size(); ++i) {
          const double scale = std::exp2(exposure), x = image.color[i] * scale;
          const float* const rgb = image.color.data() + i / 3 * 3;
          const double luminance = scale * (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]);
          // ACES: K. Narkowicz's fit at 0.6 of the light. Hable: over its value at the white point 11.2.
          const double curved = mapper == ToneMapper::aces ? 0.6 * x * (2.51 * 0.6 * x + 0.03) /
                                                                 (0.6 * x * (2.43 * 0.6 * x + 0.59) + 0.14)
                                : mapper == ToneMapper::hable
                                    ? (0.231683 * x * x + 0.013791 * x) / (0.18 * x * x + 0.3 * x + 0.018)
                                    : x / (1.0 + luminance);
          values.push_back(std::clamp(curved, 0.0, 1.0));
        }
        return values;
      };
      const auto map = PlainFlip(41, 23, options.pixels_per_degree).map(toned(one), toned(other));
      for (std::size_t i = 0; i < map.size(); ++i) expected[i] = std::max(expected[i], map[i]);
    }
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(result.map[i], expected[i], 2e-4) << i;
    EXPECT_EQ(result.exposures, 3);
  }
}

TEST(HdrFlip, black_and_mostly_black_images_come_to_an_end) {
  const ComparedImage black = uniform_image(20, 20, ColorEncoding::linear, 0, 0, 0);
  ComparedImage lamp = black;
  lamp.color[3 * 210] = lamp.color[3 * 210 + 1] = lamp.color[3 * 210 + 2] = 40.0f;
  const FlipResult none = flip(black, black);
  EXPECT_EQ(none.mean, 0.0);
  EXPECT_EQ(none.exposures, 1);
  // Any light against a black reference: exposure 0.
  const FlipResult against_black = flip(black, lamp);
  EXPECT_EQ(against_black.exposures, 1);
  EXPECT_EQ(against_black.start_exposure, 0.0);
  EXPECT_GT(against_black.max, 0.1);
  // Half of it black: the median of what is lit, here the only light.
  const FlipResult mostly_black = flip(lamp, black);
  EXPECT_EQ(mostly_black.exposures, 2);
  EXPECT_NEAR(mostly_black.start_exposure, std::log2(2.118872 / 40.0), 1e-5);
  EXPECT_EQ(mostly_black.start_exposure, mostly_black.stop_exposure);
  EXPECT_GT(mostly_black.max, 0.1);
}

TEST(HdrFlip, the_widest_range_of_light_that_floats_hold_comes_to_an_end) {
  ComparedImage image = uniform_image(8, 8, ColorEncoding::linear, 1e-38f, 1e-38f, 1e-38f);
  image.color[0] = image.color[1] = image.color[2] = 3e38f;
  const FlipResult result = flip(image, uniform_image(8, 8, ColorEncoding::linear, 0, 0, 0));
  EXPECT_GT(result.exposures, 200);
  EXPECT_LE(result.exposures, k_most_exposures);
  for (const float value : result.map) EXPECT_TRUE(value >= 0.0f && value <= 1.0f);
}

TEST(Flip, what_cannot_be_compared_is_an_error) {
  const ComparedImage image = uniform_image(4, 4, ColorEncoding::linear, 1, 1, 1);
  EXPECT_THROW(flip(image, uniform_image(4, 5, ColorEncoding::linear, 1, 1, 1)), SizeMismatch);
  ComparedImage layers = image;
  layers.color.clear();
  layers.color_channels = 0;
  EXPECT_THROW(flip(image, layers), Error);
  const auto fails = [&](const FlipOptions& options) {
    EXPECT_THROW(flip(image, image, {}, options), Error);
  };
  for (const double pixels : {0.0, 0.9, 1000.5, static_cast<double>(k_nan)}) {
    FlipOptions options;
    options.pixels_per_degree = pixels;
    fails(options);
  }
  FlipOptions options;
  options.start_exposure = 100.0;
  fails(options);
  options.start_exposure = k_nan;
  fails(options);
  options.start_exposure.reset();
  options.exposures = 1;
  fails(options);
  options.exposures = k_most_exposures + 1;
  fails(options);
}

TEST(Flip, a_progress_that_returns_false_stops_it) {
  const ComparedImage image = patchy_image(600, 300, ColorEncoding::display, "stop");
  std::uint64_t last = 0, all = 0;
  flip(image, image, {}, {}, [&](std::uint64_t done, std::uint64_t total) {
    last = done;
    all = total;
    return true;
  });
  EXPECT_GT(all, 1u);
  EXPECT_EQ(last, all);
  EXPECT_THROW(flip(image, image, {}, {}, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
}

TEST(Flip, the_default_viewing_distance_is_that_of_the_authors_tool) {
  EXPECT_NEAR(FlipOptions{}.pixels_per_degree, 67.0206, 1e-4);
}

}  // namespace
}  // namespace alidade::test
