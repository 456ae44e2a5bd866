// SPDX-License-Identifier: MIT
#include "image/point_values.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random.h"

namespace alidade {

using namespace image;

namespace {

/// All values at once.
PointValues values_in(const std::vector<double>& values) {
  return {.count = values.size(), .for_each_block = [&values](const VisitBlock& visit) {
            visit({.values = values, .first_id = 0, .ids = {}});
          }};
}

ValueRange percentiles(const std::vector<double>& values, double low, double high) {
  return percentiles_of(values_in(values), extent_of(values_in(values)), {low, high});
}

/// The definition in the header.
ValueRange percentiles_by_sorting(std::vector<double> values, double low, double high) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  std::ranges::sort(values);
  const auto last = static_cast<double>(values.size() - 1);
  return {values[static_cast<std::size_t>(std::floor(low * last / 100.0))],
          values[static_cast<std::size_t>(std::ceil(high * last / 100.0))]};
}

std::vector<std::vector<double>> families() {
  test::Random random("percentiles");
  std::vector<std::vector<double>> all;
  for (const std::size_t count : {1u, 2u, 3u, 99u, 100u, 101u, 5000u}) {
    std::vector<double> even, whole, signed_, tiny, with_nan;
    for (std::size_t i = 0; i < count; ++i) {
      even.push_back(random.between(0, 1));
      whole.push_back(std::floor(random.between(0, 7)));
      signed_.push_back(random.between(-1e9, 1e9) * random.between(0, 1));
      tiny.push_back(690000.0 + 1e-9 * std::floor(random.between(0, 50)));
      with_nan.push_back(i % 3 == 1 ? NAN : random.between(-5, 5));
    }
    for (auto* const family : {&even, &whole, &signed_, &tiny, &with_nan}) all.push_back(*family);
    all.emplace_back(count, -3.25);
  }
  all.push_back({-0.0, 0.0, -0.0, std::numeric_limits<double>::denorm_min(),
                 -std::numeric_limits<double>::denorm_min(), 1e300, -1e300});
  return all;
}

TEST(StretchTest, percentiles_are_those_of_a_sort) {
  for (const std::vector<double>& values : families()) {
    for (const ValueRange& asked :
         {ValueRange{1, 99}, {0, 100}, {50, 50}, {0, 0}, {100, 100}, {2.5, 33.3}, {0, 99.9}}) {
      EXPECT_EQ(percentiles(values, asked.low, asked.high),
                percentiles_by_sorting(values, asked.low, asked.high))
          << values.size() << " values, " << asked.low << " to " << asked.high;
    }
  }
}

TEST(StretchTest, extent_is_the_smallest_and_largest_value_and_leaves_nan_out) {
  const ValueExtent extent = extent_of(values_in({3.0, NAN, -7.5, 3.0, NAN}));
  EXPECT_EQ(extent.range, (ValueRange{-7.5, 3.0}));
  EXPECT_EQ(extent.count, 3u);
}

TEST(StretchTest, without_values_all_is_zero) {
  for (const std::vector<double>& values : {std::vector<double>{}, {NAN, NAN}}) {
    const ValueExtent extent = extent_of(values_in(values));
    EXPECT_EQ(extent.range, ValueRange());
    EXPECT_EQ(extent.count, 0u);
    EXPECT_EQ(percentiles(values, 1, 99), ValueRange());
  }
}

TEST(StretchTest, intensities_use_all_of_sixteen_bits) {
  std::vector<std::uint16_t> intensities(65536);
  for (std::size_t i = 0; i < intensities.size(); ++i) intensities[i] = static_cast<std::uint16_t>(65535 - i);
  AttributeColumns columns;
  columns.intensities = intensities;
  const PointValues values = values_of({.by = PointColor::intensity}, columns, PointValues());
  const ValueExtent extent = extent_of(values);
  EXPECT_EQ(extent.range, (ValueRange{0, 65535}));
  EXPECT_EQ(extent.count, 65536u);
  // Ranks 655.35 and 64879.65.
  EXPECT_EQ(percentiles_of(values, extent, {1, 99}), (ValueRange{655, 64880}));
}

TEST(StretchTest, number_of_threads_changes_nothing) {
  test::Random random("threads");
  std::vector<float> angles(100000);
  for (float& angle : angles) angle = static_cast<float>(random.between(-90, 90));
  AttributeColumns columns;
  columns.scan_angles = angles;
  const PointValues values = values_of(coloring_by("scan_angle"), columns, PointValues());
  const ValueRange first = percentiles_of(values, extent_of(values), {1, 99});
  for (const int threads : {1, 2, 7}) {
    tbb::task_arena arena(threads);
    arena.execute([&] { EXPECT_EQ(percentiles_of(values, extent_of(values), {1, 99}), first); });
  }
  EXPECT_EQ(first, percentiles_by_sorting({angles.begin(), angles.end()}, 1, 99));
}

TEST(StretchTest, positions_go_from_0_to_1_and_one_value_is_in_the_middle) {
  const ValueRange range{10.0, 20.0};
  EXPECT_EQ(position_in(range, 10.0), 0.0);
  EXPECT_EQ(position_in(range, 12.5), 0.25);
  EXPECT_EQ(position_in(range, 20.0), 1.0);
  EXPECT_EQ(position_in(range, -1e300), 0.0);
  EXPECT_EQ(position_in(range, 1e300), 1.0);
  EXPECT_EQ(position_in({5.0, 5.0}, 5.0), 0.5);
  EXPECT_EQ(position_in({5.0, 5.0}, 6.0), 0.5);
  EXPECT_TRUE(std::isnan(position_in(range, NAN)));
  EXPECT_EQ(position_in({-k_largest_value, k_largest_value}, 0.0), 0.5);
}

}  // namespace
}  // namespace alidade
