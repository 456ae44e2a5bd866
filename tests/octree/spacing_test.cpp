// SPDX-License-Identifier: MIT
#include "octree/spacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "octree/brute_force.h"
#include "octree/build.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;

TEST(Spacing, equals_brute_force_when_every_point_is_a_sample) {
  for (const PointFamily& family : point_families()) {
    if (family.cloud.size() > 3000) continue;
    std::vector<double> expected;
    for (std::size_t i = 0; i < family.cloud.size(); ++i) {
      // Each position counts once.
      const auto before = family.cloud.positions.begin() + static_cast<std::ptrdiff_t>(i);
      if (std::find(family.cloud.positions.begin(), before, *before) != before) continue;
      double best = HUGE_VAL;
      for (std::size_t j = 0; j < family.cloud.size(); ++j) {
        const glm::dvec3 d = family.cloud.world(i) - family.cloud.world(j);
        const double square = d.x * d.x + d.y * d.y + d.z * d.z;
        if (square > 0.0) best = std::min(best, square);
      }
      if (std::isfinite(best)) expected.push_back(std::sqrt(best));
    }
    std::sort(expected.begin(), expected.end());
    const Spacing spacing = measure_spacing(build(family.cloud), family.cloud.size());
    ASSERT_EQ(spacing.sample_count, expected.size()) << family.name;
    if (expected.empty()) continue;
    EXPECT_EQ(spacing.median, expected[expected.size() / 2]) << family.name;
    EXPECT_EQ(spacing.percentile_90, expected[expected.size() * 9 / 10]) << family.name;
  }
}

TEST(Spacing, a_sample_of_a_grid_finds_its_step) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 40000; ++i) positions.emplace_back(0.05 * (i % 200), 0.05 * (i / 200), 0.0);
  const Octree octree = build(test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  const Spacing spacing = measure_spacing(octree, 1000);
  EXPECT_NEAR(spacing.median, 0.05, 1e-12);
  EXPECT_EQ(spacing.sample_count, 1000u);
}

TEST(Spacing, at_most_as_many_points_as_asked_for_are_sampled) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 1999; ++i) positions.emplace_back(i, 0.0, 0.0);
  const Octree octree = build(test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  EXPECT_EQ(sample_positions(octree, 1000).size(), 1000u);
  EXPECT_EQ(sample_positions(octree, 1999).size(), 1999u);
  EXPECT_EQ(sample_positions(octree, 5000).size(), 1999u);
  EXPECT_EQ(sample_positions(octree, 1998).size(), 1000u);
}

TEST(Spacing, points_at_one_position_do_not_set_the_radius) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 4000; ++i)
    positions.emplace_back(69000 + 0.05 * (i % 50), 53250 + 0.05 * (i / 50), 0.0);
  const auto radius = [&] {
    return automatic_radius(build(test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)})));
  };
  const double of_site = radius();
  positions.insert(positions.end(), positions.size(), glm::dvec3(0.0));
  EXPECT_EQ(radius(), of_site);
}

TEST(Spacing, a_radius_is_found_for_clouds_without_spacing) {
  for (const PointFamily& family : point_families()) {
    EXPECT_GT(automatic_radius(build(family.cloud)), 0.0) << family.name;
  }
}

TEST(PointSpacing, is_the_distance_to_the_nth_point_elsewhere_rounded_up_to_eight_bits) {
  for (const PointFamily& family : point_families()) {
    for (const int neighbours : {1, 8}) {
      SCOPED_TRACE(family.name + " neighbour " + std::to_string(neighbours));
      const std::vector<double> expected = brute_force::spacings(family.cloud, neighbours);
      for (const test::NamedOctree& named : test::octrees_of(family.cloud, InstructionSet::best)) {
        SCOPED_TRACE(named.name);
        const Octree octree = with_spacings(named.octree, neighbours);
        if (octree.size() > 0) {
          ASSERT_EQ(test::spacings_by_id(octree), expected);
        }
      }
    }
  }
}

TEST(PointSpacing, bits_are_the_least_that_are_not_below) {
  test::Random random("spacing_bits");
  for (int i = 0; i < 100000; ++i) {
    const double metres = std::pow(10.0, random.between(-30.0, 30.0));
    const std::uint16_t bits = spacing_bits(metres);
    ASSERT_GE(spacing_of(bits), metres);
    ASSERT_LT(spacing_of(static_cast<std::uint16_t>(bits - 1)), metres);
    ASSERT_LE(spacing_of(bits), metres * 1.0079);
  }
  EXPECT_EQ(spacing_of(spacing_bits(0.0)), 0.0f);
  EXPECT_EQ(spacing_of(spacing_bits(2.5)), 2.5f);
  EXPECT_TRUE(std::isinf(spacing_of(spacing_bits(std::numeric_limits<double>::infinity()))));
}

TEST(PointSpacing, of_a_line_of_points_is_known_on_paper) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(i, 0.0, 0.0);
  points.resize(101, points[50]);  // a twin
  const Octree octree = build(test::make_cloud(points, {glm::dvec3(0.5), glm::dvec3(0.0)}));
  const Octree measured = with_spacings(octree, 4);
  const std::vector<double> spacings = test::spacings_by_id(measured);
  EXPECT_EQ(spacings[0], 4.0);
  EXPECT_EQ(spacings[20], 2.0);
  EXPECT_EQ(spacings[50], 2.0);
  EXPECT_EQ(spacings[100], 2.0);
  EXPECT_EQ(spacings[51], 2.0) << "the twins count as two";
}

TEST(PointSpacing, numbers_of_neighbours_out_of_range_are_errors) {
  const Octree octree = build(point_families().front().cloud);
  EXPECT_THROW(with_spacings(octree, 0), Error);
  EXPECT_THROW(with_spacings(octree, k_most_spacing_neighbours + 1), Error);
}

}  // namespace
}  // namespace alidade
