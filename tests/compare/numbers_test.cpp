// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "base/exact_math.h"
#include "compare/metrics/pixel_sums.h"
#include "image/srgb.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

TEST(Logarithm, exponential_is_that_of_the_c_library) {
  for (double x = -700.0; x <= 0.0; x += 0.37) EXPECT_NEAR(exponential(x) / std::exp(x), 1.0, 1e-12) << x;
  EXPECT_EQ(exponential(0.0), 1.0);
}

TEST(Logarithm, binary_logarithm_is_that_of_the_c_library) {
  for (double x = 1e-300; x < 1e300; x *= 1.7)
    EXPECT_NEAR(binary_logarithm(x), std::log2(x), 1e-15 * std::max(1.0, std::fabs(std::log2(x)))) << x;
  EXPECT_EQ(binary_logarithm(1.0), 0.0);
  EXPECT_EQ(binary_logarithm(0.125), -3.0);
}

// IEC 61966-2-1, with the C library's power.
TEST(SrgbCurve, tables_are_the_curve_at_codes_and_between_them) {
  const auto linear = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  const auto display = [](double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  };
  for (int i = 0; i <= 100000; ++i) {
    const auto value = static_cast<float>(i / 100000.0);
    EXPECT_NEAR(linear_from_srgb_table().at(value), linear(value), 2e-7) << value;
    EXPECT_NEAR(srgb_from_linear_table().at(value), display(value), 5e-7) << value;
  }
  for (int code = 0; code <= 255; ++code) {
    const float value = static_cast<float>(code) / 255.0f;
    EXPECT_NEAR(linear_from_srgb_table().at(value), linear(code / 255.0), 6e-8) << code;
  }
  EXPECT_EQ(linear_from_srgb_table().at(-1.0f), 0.0f);
  EXPECT_EQ(linear_from_srgb_table().at(2.0f), 1.0f);
  EXPECT_EQ(linear_from_srgb_table().at(std::nanf("")), 0.0f);
}

TEST(FloatRanks, ranks_and_quantiles_are_those_of_sorted_values) {
  Random random("float_ranks");
  std::vector<float> values;
  for (int i = 0; i < 5000; ++i) {
    const double size = std::exp2(random.between(-20.0, 3.0));
    values.push_back(static_cast<float>(i % 7 == 0 ? 0.25 : size));
    // What is left out.
    if (i % 3 == 0) values.push_back(-1.0f);
  }
  std::vector<float> sorted;
  std::ranges::copy_if(values, std::back_inserter(sorted), [](float value) { return value >= 0.0f; });
  std::ranges::sort(sorted);
  const auto value_at = [&](std::size_t i) { return values[i]; };
  const FloatCounts counts = count_upper_halves(values.size(), value_at);
  for (const std::uint64_t rank : {0u, 1u, 77u, 2500u, 4998u, 4999u})
    EXPECT_EQ(value_of_rank(values.size(), value_at, counts, rank), sorted[rank]) << rank;
  double sum = 0.0;
  for (const float value : sorted) sum += value;
  for (const double share : {0.0, 0.25, 0.5, 0.75, 0.999}) {
    double running = 0.0;
    const auto expected =
        std::ranges::find_if(sorted, [&](float value) { return (running += value) > share * sum; });
    EXPECT_EQ(weighted_rank(values.size(), value_at, counts, share), *expected) << share;
  }
}

// More than one task counts, and their counts are added up.
TEST(FloatRanks, ranks_among_millions_are_those_of_sorted_values) {
  std::vector<float> values(std::size_t{3} << 20);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(static_cast<std::uint32_t>(i) * 2654435761u >> 8) * 0x1p-24f;
  const auto value_at = [&](std::size_t i) { return values[i]; };
  const FloatCounts counts = count_upper_halves(values.size(), value_at);
  std::vector<float> sorted = values;
  std::ranges::sort(sorted);
  for (const std::size_t rank : {std::size_t{0}, values.size() / 3, values.size() - 1})
    EXPECT_EQ(value_of_rank(values.size(), value_at, counts, rank), sorted[rank]) << rank;
  double sum = 0.0, running = 0.0;
  for (const float value : sorted) sum += value;
  const auto median =
      std::ranges::find_if(sorted, [&](float value) { return (running += value) > 0.5 * sum; });
  EXPECT_EQ(weighted_rank(values.size(), value_at, counts, 0.5), *median);
}

TEST(FloatRanks, a_weighted_quantile_of_zeros_is_zero) {
  const auto value_at = [](std::size_t) { return 0.0f; };
  EXPECT_EQ(weighted_rank(10, value_at, count_upper_halves(10, value_at), 0.5), 0.0f);
  EXPECT_EQ(weighted_rank(0, value_at, count_upper_halves(0, value_at), 0.5), 0.0f);
}

}  // namespace
}  // namespace alidade::test
