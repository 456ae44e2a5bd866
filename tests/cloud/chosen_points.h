// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "cloud/point_cloud.h"
#include "tests/cloud/cloud_test_support.h"

// Clouds with every kind of column, and the columns of some of their rows, for tests on what crops and thins.

namespace alidade::test {

/// Random points in a box of `steps` lattice steps around the origin of the lattice, every column filled.
inline PointCloud full_cloud(std::size_t count, int steps, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](int end) { return static_cast<int>(engine() % static_cast<std::uint64_t>(end)); };
  const auto word = [&] { return static_cast<std::uint16_t>(engine()); };
  const auto byte = [&] { return static_cast<std::uint8_t>(engine()); };
  PointCloud cloud;
  cloud.lattice = {.scale = {0.01, 0.01, 0.02}, .offset = {690000, 5325000, 100}};
  cloud.extra_dimensions.resize(2);
  cloud.extra_dimensions[0].name = "three bytes";
  cloud.extra_dimensions[0].type = ScalarType::bytes;
  cloud.extra_dimensions[0].byte_count = 3;
  cloud.extra_dimensions[1].name = "double";
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions.emplace_back(below(2 * steps) - steps, below(2 * steps) - steps, below(steps));
    cloud.colors.emplace_back(word(), word(), word());
    cloud.near_infrared.push_back(word());
    cloud.intensities.push_back(word());
    cloud.classifications.push_back(byte());
    cloud.returns.push_back({.number = byte(), .count = byte()});
    cloud.flags.push_back(byte());
    cloud.scan_angles.push_back(static_cast<float>(below(180)));
    cloud.user_data.push_back(byte());
    cloud.point_source_ids.push_back(word());
    cloud.gps_times.push_back(static_cast<double>(i));
    cloud.normals.emplace_back(below(9), below(9), below(9));
    for (int k = 0; k < 3; ++k) cloud.extra_dimensions[0].values.push_back(byte());
    for (int k = 0; k < 8; ++k) cloud.extra_dimensions[1].values.push_back(byte());
  }
  return cloud;
}

/// The cloud that has these rows of another one, copied one by one.
inline PointCloud rows_of(const PointCloud& cloud, const std::vector<std::size_t>& rows) {
  PointCloud some;
  some.lattice = cloud.lattice;
  some.extra_dimensions = cloud.extra_dimensions;
  for (ExtraDimension& dimension : some.extra_dimensions) dimension.values.clear();
  const auto add = [](auto& column, const auto& all, std::size_t row) {
    if (!all.empty()) column.push_back(all[row]);
  };
  for (const std::size_t row : rows) {
    add(some.positions, cloud.positions, row);
    add(some.colors, cloud.colors, row);
    add(some.near_infrared, cloud.near_infrared, row);
    add(some.intensities, cloud.intensities, row);
    add(some.classifications, cloud.classifications, row);
    add(some.returns, cloud.returns, row);
    add(some.flags, cloud.flags, row);
    add(some.scan_angles, cloud.scan_angles, row);
    add(some.user_data, cloud.user_data, row);
    add(some.point_source_ids, cloud.point_source_ids, row);
    add(some.gps_times, cloud.gps_times, row);
    add(some.normals, cloud.normals, row);
    for (std::size_t i = 0; i < some.extra_dimensions.size(); ++i) {
      const auto bytes = static_cast<std::size_t>(cloud.extra_dimensions[i].byte_count);
      const auto first = cloud.extra_dimensions[i].values.begin() + static_cast<std::ptrdiff_t>(row * bytes);
      some.extra_dimensions[i].values.insert(some.extra_dimensions[i].values.end(), first,
                                             first + static_cast<std::ptrdiff_t>(bytes));
    }
  }
  return some;
}

/// Expects equal points, every column bit for bit.
inline void expect_same_columns(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.lattice, b.lattice);
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.colors, b.colors));
  EXPECT_TRUE(same_bits(a.near_infrared, b.near_infrared));
  EXPECT_TRUE(same_bits(a.intensities, b.intensities));
  EXPECT_TRUE(same_bits(a.classifications, b.classifications));
  EXPECT_TRUE(same_bits(a.returns, b.returns));
  EXPECT_TRUE(same_bits(a.flags, b.flags));
  EXPECT_TRUE(same_bits(a.scan_angles, b.scan_angles));
  EXPECT_TRUE(same_bits(a.user_data, b.user_data));
  EXPECT_TRUE(same_bits(a.point_source_ids, b.point_source_ids));
  EXPECT_TRUE(same_bits(a.gps_times, b.gps_times));
  EXPECT_TRUE(same_bits(a.normals, b.normals));
  ASSERT_EQ(a.extra_dimensions.size(), b.extra_dimensions.size());
  for (std::size_t i = 0; i < a.extra_dimensions.size(); ++i) {
    EXPECT_EQ(a.extra_dimensions[i].name, b.extra_dimensions[i].name);
    EXPECT_EQ(a.extra_dimensions[i].values, b.extra_dimensions[i].values);
  }
}

}  // namespace alidade::test
