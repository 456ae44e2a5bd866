// SPDX-License-Identifier: MIT
#include "surface/point_disc.h"

#include <gtest/gtest.h>

#include <limits>

namespace alidade {
namespace {

/// On the plane z = 5, a quarter of a metre below its point. The sheet ends 0.5 spacings beside the point,
/// towards +x.
const PointSurface k_surface{
    .exists = true, .normal = glm::dvec3(0, 0, 1), .height = 0.25, .thickness = 0.01};
const PointDisc k_disc = point_disc({1.0, 2.0, 5.25}, k_surface, 0.5);

/// The stored edge nearest to +x and to so many spacings.
std::uint8_t packed_edge(double distance) {
  std::uint8_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int packed = 1; packed < 256; ++packed) {
    const SheetEdge edge = unpack_edge(static_cast<std::uint8_t>(packed), k_surface.normal);
    const double off =
        std::fabs(edge.distance - distance) + glm::length(edge.direction - glm::dvec3(1, 0, 0));
    if (off < least) {
      least = off;
      best = static_cast<std::uint8_t>(packed);
    }
  }
  return best;
}

TEST(PointDisc, lies_on_the_plane_of_its_sheet) {
  EXPECT_EQ(k_disc.center, glm::dvec3(1, 2, 5));
  EXPECT_EQ(plane_crossing(k_disc, {0, 0, 8}, {0, 0, -1}), 3.0);
  EXPECT_EQ(plane_crossing(k_disc, {0, 0, 8}, {0, 0, 1}), -3.0);
  EXPECT_EQ(plane_crossing(k_disc, {0, 0, 8}, {0.6, 0, -0.8}), 3.0 / 0.8);
  EXPECT_FALSE(plane_crossing(k_disc, {0, 0, 8}, {1, 0, 0}));
  EXPECT_FALSE(plane_crossing(k_disc, {0, 0, 5}, {1, 0, 0}));
}

TEST(PointDisc, is_as_wide_as_the_radius_of_its_point) {
  EXPECT_TRUE(is_within_radius(k_disc, {1.5, 2, 5.25}));
  EXPECT_FALSE(is_within_radius(k_disc, {std::nextafter(1.5, 2.0), 2, 5.25}));
  // On the plane, a quarter of a metre below the point: sqrt(0.5^2 - 0.25^2) = 0.433.
  EXPECT_TRUE(is_within_radius(k_disc, {1.43, 2, 5}));
  EXPECT_FALSE(is_within_radius(k_disc, {1.44, 2, 5}));
}

TEST(PointDisc, ends_where_its_sheet_does) {
  // The radius is two spacings of 0.25 m, so half a spacing is 0.125 m.
  const std::uint8_t packed = packed_edge(0.5);
  const SheetEdge edge = unpack_edge(packed, k_surface.normal);
  ASSERT_NEAR(glm::dot(edge.direction, glm::dvec3(1, 0, 0)), 1.0, 0.01);
  ASSERT_NEAR(edge.distance, 0.5, 0.1);
  const auto is_beyond = [&](double metres, double shift) {
    return is_beyond_edge(k_disc, glm::dvec3(1, 2, 5) + metres * edge.direction, packed, 2.0, shift);
  };
  for (const double shift : {0.0, 1.0, -0.25}) {
    const double end = 0.25 * (edge.distance + shift);
    EXPECT_FALSE(is_beyond(end - 1e-9, shift));
    EXPECT_TRUE(is_beyond(end + 1e-9, shift));
    EXPECT_FALSE(is_beyond(-0.4, shift));
  }
  EXPECT_FALSE(is_beyond_edge(k_disc, {9, 2, 5}, 0, 2.0)) << "no edge";
}

TEST(PointDisc, is_part_of_surfaces_that_its_plane_passes) {
  const auto is_part = [](const glm::dvec3& position, double reach, double thickness) {
    return is_part_of_surface(k_disc, position, reach, thickness);
  };
  // Near: within three radii, 1.5 m, of the point, or within the reach.
  EXPECT_TRUE(is_part({2.45, 2, 5}, 0.1, 0.01));
  EXPECT_FALSE(is_part({2.55, 2, 5}, 0.1, 0.01));
  EXPECT_TRUE(is_part({2.55, 2, 5}, 2.0, 0.01));
  EXPECT_FALSE(is_part({3.05, 2, 5}, 2.0, 0.01));
  // The plane counts, not the point.
  EXPECT_TRUE(is_part({1, 2, 5.125}, 0.1, 0.125));
  EXPECT_TRUE(is_part({1, 2, 4.875}, 0.1, 0.125));
  EXPECT_FALSE(is_part({1, 2, 5.25}, 0.1, 0.125));
}

}  // namespace
}  // namespace alidade
