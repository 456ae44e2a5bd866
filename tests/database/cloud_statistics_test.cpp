// SPDX-License-Identifier: MIT
#include "database/cloud_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include "tests/support/random.h"

namespace alidade::test {
namespace {

using namespace database;

PointCloud scattered(std::size_t count) {
  Random random("statistics");
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 500}};
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions.push_back(
        LatticePosition(random.below(10'000), random.below(20'000), random.below(3000)));
    cloud.intensities.push_back(static_cast<std::uint16_t>(random.below(1000)));
    cloud.classifications.push_back(static_cast<std::uint8_t>(random.below(3)));
    cloud.returns.push_back({static_cast<std::uint8_t>(1 + random.below(2)), 2});
    cloud.flags.push_back(static_cast<PointFlags>(random.below(2) == 0 ? 0b100 : 0b1000'1000));
    cloud.gps_times.push_back(2.5e8 + 0.5 * static_cast<double>(i));
  }
  cloud.gps_time_is_standard = true;
  return cloud;
}

TEST(StatisticsTest, columns_are_what_sorting_them_says) {
  const PointCloud cloud = scattered(1000);
  const CloudStatistics statistics = statistics_of(points_of(cloud));
  const auto column = std::ranges::find(statistics.columns, "intensity", &ColumnStatistics::name);
  ASSERT_NE(column, statistics.columns.end());
  std::vector<std::uint16_t> sorted = cloud.intensities;
  std::ranges::sort(sorted);
  EXPECT_EQ(column->least, sorted.front());
  EXPECT_EQ(column->most, sorted.back());
  EXPECT_EQ(column->quantiles[0], sorted[9]);
  EXPECT_EQ(column->quantiles[2], sorted[499]);
  EXPECT_EQ(column->quantiles[4], sorted[989]);
  double sum = 0.0, squares = 0.0;
  for (const double value : sorted) sum += value, squares += value * value;
  EXPECT_NEAR(column->mean, sum / 1000, 1e-9);
  EXPECT_NEAR(column->deviation, std::sqrt(squares / 1000 - sum / 1000 * sum / 1000), 1e-6);
}

TEST(StatisticsTest, quantiles_are_exact_for_any_numbers) {
  constexpr double k_most = std::numeric_limits<double>::max(),
                   k_least = std::numeric_limits<double>::denorm_min();
  Random random("quantiles");
  const std::function<double()> families[] = {
      [&] { return random.between(-1.0, 1.0); },
      [&] { return 3.1e8 + 1e-7 * random.between(0.0, 1.0); },
      [&] { return std::ldexp(random.between(-1.0, 1.0), static_cast<int>(random.below(2000)) - 1000); },
      [&] { return static_cast<double>(random.below(5)) - 2.0; },
      [&] { return random.below(2) == 0 ? -k_most : k_least; },
      [] { return -7.25; },
      [&] { return random.below(2) == 0 ? -0.0 : 0.0; },
  };
  for (const auto& family : families) {
    for (const std::size_t count : {1, 2, 99, 100, 2000}) {
      PointCloud cloud;
      cloud.positions.resize(count);
      std::ranges::generate_n(std::back_inserter(cloud.gps_times), static_cast<std::ptrdiff_t>(count),
                              family);
      const CloudStatistics statistics = statistics_of(points_of(cloud));
      const auto column = std::ranges::find(statistics.columns, "gps_time", &ColumnStatistics::name);
      ASSERT_NE(column, statistics.columns.end());
      std::ranges::sort(cloud.gps_times);
      EXPECT_EQ(column->least, cloud.gps_times.front());
      EXPECT_EQ(column->most, cloud.gps_times.back());
      for (std::size_t i = 0; i < k_quantiles.size(); ++i) {
        const double rank = std::ceil(k_quantiles[i] * static_cast<double>(count));
        EXPECT_EQ(column->quantiles[i], cloud.gps_times[static_cast<std::size_t>(rank) - 1]) << count;
      }
    }
  }
}

TEST(StatisticsTest, counts_are_those_of_the_rows) {
  const PointCloud cloud = scattered(500);
  const CloudStatistics statistics = statistics_of(points_of(cloud));
  for (int kind = 0; kind < 3; ++kind)
    EXPECT_EQ(statistics.classes.at(kind), std::ranges::count(cloud.classifications, kind));
  EXPECT_EQ(statistics.returns.at({1, 2}) + statistics.returns.at({2, 2}), 500u);
  ASSERT_TRUE(statistics.flags);
  const auto& flags = *statistics.flags;
  EXPECT_EQ(flags[2], std::ranges::count(cloud.flags, 0b100));
  EXPECT_EQ(flags[2] + flags[3], 500u);
  EXPECT_EQ(flags[3], flags[4]);
}

TEST(StatisticsTest, density_is_that_of_the_cells_with_points) {
  const PointCloud one = scattered(40'000);
  const CloudStatistics full = statistics_of(points_of(one));
  ASSERT_TRUE(full.coverage);
  EXPECT_NEAR(full.coverage->density, 200.0, 6.0);
  // The same points twice, the second time a hundred metres away: the gap between them does not count.
  PointCloud two = scattered(40'000);
  for (std::size_t row = 0; row < two.size(); row += 2) two.positions[row].x += 100'000;
  EXPECT_NEAR(statistics_of(points_of(two)).coverage->density, 100.0, 8.0);
  PointCloud line;
  line.positions = {{0, 0, 0}, {5, 0, 0}};
  EXPECT_FALSE(statistics_of(points_of(line)).coverage);
}

TEST(StatisticsTest, values_that_mean_none_do_not_count) {
  PointCloud cloud = scattered(4);
  ExtraDimension height = plain_dimension("Height", ScalarType::int16);
  height.scale = 0.01, height.has_scale = true;
  height.no_data.emplace();
  height.no_data->fill(0);
  height.values = {0, 0, 100, 0, 200, 0, 44, 1};
  cloud.extra_dimensions = {height};
  const CloudStatistics statistics = statistics_of(points_of(cloud));
  const auto column = std::ranges::find(statistics.columns, "Height", &ColumnStatistics::name);
  ASSERT_NE(column, statistics.columns.end());
  EXPECT_EQ(column->count, 3u);
  EXPECT_EQ(column->missing, 1u);
  EXPECT_DOUBLE_EQ(column->mean, 2.0);
}

TEST(GpsTimeTest, moments_count_leap_seconds) {
  const auto text = [](double seconds) { return date_time_text(*moment_of_gps_time(seconds)); };
  // Source: 1,000,000,000 s of GPS time were 14 September 2011, 01:46:25 UTC (15 leap seconds).
  EXPECT_EQ(text(0.0), "2011-09-14T01:46:25Z");
  EXPECT_EQ(text(-1e9), "1980-01-06T00:00:00Z");
  // The last second before, and the first after, the leap second of 31 December 2016.
  EXPECT_EQ(text(1167264016.0 - 1e9), "2016-12-31T23:59:59Z");
  EXPECT_EQ(text(1167264018.0 - 1e9), "2017-01-01T00:00:00Z");
  EXPECT_FALSE(moment_of_gps_time(-1.1e9));
}

TEST(StatisticsTest, can_be_stopped_within_a_column) {
  PointCloud cloud;
  cloud.positions.resize(600'000);
  std::uint64_t calls = 0;
  const CloudStatistics statistics =
      statistics_of(points_of(cloud), [&](std::uint64_t done, std::uint64_t total) {
        EXPECT_LE(done, total);
        ++calls;
        return true;
      });
  EXPECT_GE(calls, 4 * statistics.columns.size());
  const auto stop = [](std::uint64_t done, std::uint64_t) { return done > 0; };
  EXPECT_THROW(statistics_of(points_of(cloud), stop), Cancelled);
}

}  // namespace
}  // namespace alidade::test
