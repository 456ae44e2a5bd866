// SPDX-License-Identifier: MIT
#include "extensions/radio/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

// A link of 100 m along x at 2.4 GHz: its zone is 1.77 m wide in the middle.
constexpr double k_length = 100.0, k_wavelength = k_speed_of_light / 2.4e9;
const double k_radius = 0.5 * std::sqrt(k_wavelength * k_length);

// Of walls: points every 2 cm, and discs of the same radius. So an edge lies 1.9 cm beyond its last row.
constexpr double k_spacing = 0.02, k_overhang = 0.019;

FresnelClearance clearance(const Occluders& occluders, const LineOptions& options = {}) {
  return fresnel_clearance(occluders, {{0, 0, 0}}, {{k_length, 0, 0}}, options, k_wavelength);
}

/// A half plane at x whose edge runs along y at this height, as far as the zone is concerned; or the one
/// above it.
void add_half_plane(WallCloud& cloud, double x, double edge, bool above = false) {
  const double side = above ? 1.0 : -1.0;
  cloud.add({x, -1.9, edge + side * k_overhang}, {0, 3.8, 0}, {0, 0, side * (2.5 - side * edge)}, k_spacing);
}

Occluders half_plane(double x, double edge) {
  WallCloud cloud;
  add_half_plane(cloud, x, edge);
  return cloud.occluders({.radius = k_spacing});
}

/// Share of a circle's area beyond a chord at this share of its radius from the middle.
double segment(double share) {
  return (std::acos(share) - share * std::sqrt(1.0 - share * share)) / std::numbers::pi;
}

TEST(Fresnel, radius_is_that_of_the_recommendation) {
  // ITU-R P.526: 550 sqrt(d1 d2 / ((d1 + d2) f)) metres, distances in km, f in MHz, good to 0.5 %.
  EXPECT_NEAR(fresnel_radius(k_speed_of_light / 2.4e9, 1000.0), 550.0 * std::sqrt(0.25 / 2400.0), 0.03);
  EXPECT_NEAR(fresnel_radius(k_speed_of_light / 868e6, 4000.0), 550.0 * std::sqrt(4.0 / (4 * 868.0)), 0.1);
}

TEST(Fresnel, an_empty_zone_is_free) {
  const FresnelClearance free = clearance(half_plane(50, -1.8));
  EXPECT_EQ(free.obstructed, 0.0);
  EXPECT_EQ(free.worst, 0.0);
  EXPECT_EQ(free.cut_off, 0.0);
  EXPECT_EQ(free.inner, 0.0);
  EXPECT_EQ(free.points, 0u);
  EXPECT_TRUE(free.is_clear);
  EXPECT_FALSE(free.nearest);
  EXPECT_TRUE(free.obstructions.empty());
  EXPECT_NEAR(free.radius, 1.767, 1e-3);
}

TEST(Fresnel, an_edge_on_the_axis_obstructs_half) {
  for (const double x : {20.0, 50.0, 77.0}) {
    const FresnelClearance half = clearance(half_plane(x, 0.0));
    EXPECT_NEAR(half.obstructed, 0.5, 0.01) << x;
    EXPECT_NEAR(half.inner, 0.5, 0.02) << x;
    EXPECT_NEAR(half.worst, half.obstructed, 1e-9) << x;
    EXPECT_NEAR(half.worst_t, x, 1e-3) << x;
    EXPECT_NEAR(half.cut_off, 0.0, 1e-6) << x;
    EXPECT_FALSE(half.is_clear) << x;
  }
}

TEST(Fresnel, an_edge_beside_the_axis_obstructs_a_segment_of_the_circle) {
  for (const double share : {-0.8, -0.3, 0.2, 0.5, 0.61, 0.9}) {
    const FresnelClearance part = clearance(half_plane(50, -share * k_radius));
    EXPECT_NEAR(part.obstructed, segment(share), 0.01) << share;
    EXPECT_EQ(part.is_clear, share > 0.6) << share;
    if (share > 0.6) {
      EXPECT_EQ(part.inner, 0.0) << share;
      EXPECT_NEAR(part.nearest_share, share + k_overhang / k_radius, 1e-3) << share;
      EXPECT_NEAR(part.nearest->t, 50.0, 1e-6);
    }
  }
}

TEST(Fresnel, away_from_the_middle_the_zone_is_narrower) {
  const double there = 2.0 * k_radius * std::sqrt(0.1 * 0.9);
  EXPECT_NEAR(clearance(half_plane(10, -0.5 * there)).obstructed, segment(0.5), 0.015);
  EXPECT_TRUE(clearance(half_plane(10, -0.65 * there)).is_clear);
  EXPECT_FALSE(clearance(half_plane(10, -0.55 * there)).is_clear);
}

TEST(Fresnel, ground_below_a_link_obstructs_what_dips_into_it) {
  // The plane z = -radius / 2. What lies below is a segment of each cross-section, and of the volume the cap
  // of a sphere.
  WallCloud cloud;
  cloud.add({0, -2, -0.5 * k_radius}, {k_length, 0, 0}, {0, 4, 0}, 0.1);
  const FresnelClearance ground = clearance(cloud.occluders({.radius = 0.1}));
  EXPECT_NEAR(ground.obstructed, segment(0.5), 0.01);
  EXPECT_NEAR(ground.worst, segment(0.5), 0.02);
  EXPECT_NEAR(ground.worst_t, 50.0, 10.0);
  EXPECT_NEAR(ground.cut_off, 0.25 * 2.5 / 4.0, 0.01);
  EXPECT_FALSE(ground.is_clear);
  EXPECT_NEAR(ground.nearest_share, 0.5, 1e-3);
}

TEST(Fresnel, worst_cross_section_distinguishes_one_wall_from_two) {
  WallCloud cloud;
  add_half_plane(cloud, 30, 0.0);
  add_half_plane(cloud, 70, 0.0, true);
  const FresnelClearance both = clearance(cloud.occluders({.radius = k_spacing}));
  EXPECT_NEAR(both.obstructed, 1.0, 0.01);
  EXPECT_NEAR(both.worst, 0.5, 0.01);
  // As near as the zone is wide, 3.53 m, they are one cross-section.
  for (const auto& [x, worst] : {std::pair(33.0, 1.0), std::pair(34.0, 0.5)}) {
    WallCloud near;
    add_half_plane(near, 30, 0.0);
    add_half_plane(near, x, 0.0, true);
    EXPECT_NEAR(clearance(near.occluders({.radius = k_spacing})).worst, worst, 0.02) << x;
  }
}

TEST(Fresnel, points_that_obstruct_are_listed_with_their_shares) {
  const FresnelClearance half = clearance(half_plane(50, 0.0));
  double sum = 0.0, last = 1.0;
  for (const Obstruction& one : half.obstructions) {
    EXPECT_LE(one.share, last);
    last = one.share;
    sum += one.share;
  }
  EXPECT_NEAR(sum, half.obstructed, 1e-12);
  EXPECT_GT(half.obstructions.size(), 100u);
  EXPECT_GT(half.points, half.obstructions.size());
}

TEST(Fresnel, a_wire_within_the_inner_zone_spoils_the_verdict) {
  // Too thin for any tube to meet.
  for (const double share : {0.3, 0.59, 0.61}) {
    const Occluders occluders = WallCloud()
                                    .add({50, 0, -share * k_radius})
                                    .occluders({.shape = OccluderShape::sphere, .radius = 1e-4});
    EXPECT_EQ(clearance(occluders).is_clear, share > 0.6);
    EXPECT_EQ(clearance(occluders).points, 1u);
    EXPECT_NEAR(clearance(occluders).nearest_share, share, 1e-4);
  }
}

TEST(Fresnel, points_that_do_not_block_do_not_count) {
  WallCloud cloud;
  add_half_plane(cloud, 50, 0.0);
  const FresnelClearance free =
      clearance(cloud.occluders({.radius = k_spacing, .counts = [](std::uint64_t) { return false; }}));
  EXPECT_EQ(free.obstructed, 0.0);
  EXPECT_EQ(free.points, 0u);
  EXPECT_TRUE(free.is_clear);
}

TEST(Fresnel, end_margins_are_not_tested) {
  EXPECT_GT(clearance(half_plane(4, 0.0)).obstructed, 0.4);
  const FresnelClearance free = clearance(half_plane(4, 0.0), {.end_margin = 5.0});
  EXPECT_EQ(free.obstructed, 0.0);
  EXPECT_TRUE(free.is_clear);
  EXPECT_EQ(clearance(half_plane(50, 0.0), {.end_margin = 60.0}).obstructed, 0.0);
}

TEST(Fresnel, the_zone_sags_with_the_curvature) {
  // By as much as the inner 60 % leave below the axis in the middle.
  const double sag = 0.3 * k_radius;
  const double earth_radius = k_length * k_length / (8.0 * sag);
  EXPECT_TRUE(clearance(half_plane(50, -0.7 * k_radius)).is_clear);
  const FresnelClearance bent = clearance(half_plane(50, -0.7 * k_radius), {.earth_radius = earth_radius});
  EXPECT_FALSE(bent.is_clear);
  EXPECT_NEAR(bent.obstructed, segment(0.4), 0.01);
}

TEST(Fresnel, bad_wavelengths_and_counted_crossings_are_errors) {
  const Occluders occluders = half_plane(50, 0.0);
  for (const double wavelength : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_THROW(fresnel_clearance(occluders, {{0, 0, 0}}, {{9, 0, 0}}, {}, wavelength), Error);
  const Occluders through(occluders.octree(), {.transparency = 2});
  EXPECT_THROW(clearance(through), Error);
}

TEST(Frequency, is_a_number_with_a_unit) {
  EXPECT_EQ(parse_frequency("5.8GHz"), 5.8e9);
  EXPECT_EQ(parse_frequency("2.4"), 2.4e9);
  EXPECT_EQ(parse_frequency("868 mhz"), 868e6);
  EXPECT_EQ(parse_frequency(" 60 ghz "), 60e9);
  for (const char* const wrong :
       {"", "GHz", "5.8GHzz", "5.8kHz", "x5", "0", "-1", "nan", "0.5MHz", "1001", "5.8G"})
    EXPECT_FALSE(parse_frequency(wrong)) << wrong;
}

}  // namespace
}  // namespace alidade::test
