// SPDX-License-Identifier: MIT
#include "visibility/sky/sky_view.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/instruction_set.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {

using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;
// The share of one direction of many, and a disc's width above an edge.
constexpr double k_tolerance = 0.012;
// Of the discs of points 0.15 m apart: no gaps, and little over the edges.
constexpr double k_radius = 0.11;

float view_of(const Occluders& occluders, const SkyTarget& target, const SkyViewOptions& options) {
  float view = -1.0f;
  sky_views(occluders, std::span(&target, 1), options, std::span(&view, 1));
  return view;
}

/// The point nearest to a position, as a target.
SkyTarget target_near(const Occluders& occluders, const Points& points, const glm::dvec3& position,
                      const std::optional<glm::dvec3>& outward = {}) {
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (glm::distance(points[i], position) < glm::distance(points[nearest], position)) nearest = i;
  return target_on_point(occluders, nearest, points[nearest], outward);
}

Points canyon(double half_width, double height) {
  constexpr double k_length = 160.0, k_spacing = 0.15;
  Points points;
  add_rectangle(points, {-half_width, -0.5 * k_length, 0}, {2.0 * half_width, 0, 0}, {0, k_length, 0},
                k_spacing);
  for (const double side : {-half_width, half_width})
    add_rectangle(points, {side, -0.5 * k_length, 0}, {0, k_length, 0}, {0, 0, height}, k_spacing);
  return points;
}

TEST(SkyView, of_a_street_canyon_is_its_formula) {
  // In the middle between infinite walls seen under the angle b: cos b (Johnson and Watson 1984).
  constexpr double k_half_width = 4.0, k_height = 6.0;
  const Points points = canyon(k_half_width, k_height);
  const Occluders occluders(octree_of(points), {.radius = k_radius});
  const double expected = std::cos(std::atan2(k_height, k_half_width));
  const SkyTarget on_ground = target_near(occluders, points, {0, 0, 0});
  const SkyTarget above = target_in_open(end_near_surface(occluders, {0.03, 0.02, 0.05}));
  for (const SkyReceiver receiver : {SkyReceiver::horizontal, SkyReceiver::surface}) {
    EXPECT_NEAR(view_of(occluders, on_ground, {512, receiver}), expected, k_tolerance);
    EXPECT_NEAR(view_of(occluders, on_ground, {.receiver = receiver}), expected, 0.035);
    EXPECT_NEAR(view_of(occluders, above, {512, receiver}), expected, k_tolerance);
  }
  const SkyShares shares = sky_shares(occluders, above.front, 4096);
  EXPECT_NEAR(shares.cosine_weighted, expected, k_tolerance);
  EXPECT_NEAR(shares.solid_angle, 1.0 - 2.0 * std::atan2(k_height, k_half_width) / std::numbers::pi,
              k_tolerance);
  const std::vector<HorizonDirection> line = horizon(occluders, above.front, {.step = 1.0});
  EXPECT_NEAR(sky_above(line).cosine_weighted, expected, k_tolerance);
}

TEST(SkyView, beside_an_infinite_wall_is_that_of_a_half_plane) {
  // The wall is seen under the angle b from the ground: (1 + cos b) / 2, and 1 - b / pi of the solid angle.
  constexpr double k_distance = 3.0, k_height = 5.0;
  Points points;
  add_rectangle(points, {-120, k_distance, 0}, {240, 0, 0}, {0, 0, k_height}, 0.15);
  const Occluders occluders(octree_of(points), {.radius = k_radius});
  const SkyTarget target = target_in_open(end_near_surface(occluders, {0, 0, 0}));
  const double angle = std::atan2(k_height, k_distance);
  EXPECT_NEAR(view_of(occluders, target, {512, SkyReceiver::horizontal}), 0.5 * (1.0 + std::cos(angle)),
              k_tolerance);
  EXPECT_NEAR(sky_shares(occluders, target.front, 4096).solid_angle, 1.0 - angle / std::numbers::pi,
              k_tolerance);
}

TEST(SkyView, of_an_open_slope_is_half_of_one_plus_its_cosine) {
  for (const double slope : {0.0, 30.0, 60.0, 90.0}) {
    const glm::dvec3 up_hill(0.0, std::cos(slope * k_degree), std::sin(slope * k_degree));
    Points points;
    add_rectangle(points, {-3, 0, 0}, {6, 0, 0}, 6.0 * up_hill, 0.1);
    const Occluders occluders(octree_of(points), {});
    const SkyTarget target = target_near(occluders, points, 3.0 * up_hill);
    EXPECT_NEAR(view_of(occluders, target, {512}), 0.5 * (1.0 + std::cos(slope * k_degree)), k_tolerance)
        << slope;
    // A horizontal receiver on it loses what lies behind the slope: the wedge of a half plane.
    EXPECT_NEAR(view_of(occluders, target, {512, SkyReceiver::horizontal}),
                0.5 * (1.0 + std::cos(slope * k_degree)), k_tolerance)
        << slope;
  }
}

TEST(SkyView, of_a_house_wall_is_that_of_its_outside) {
  // A box with a roof: the wall's inner side sees no sky at all.
  Points points;
  for (const double x : {-3.0, 3.0}) add_rectangle(points, {x, -3, 0}, {0, 6, 0}, {0, 0, 3}, 0.1);
  for (const double y : {-3.0, 3.0}) add_rectangle(points, {-3, y, 0}, {6, 0, 0}, {0, 0, 3}, 0.1);
  add_rectangle(points, {-3, -3, 3}, {6, 0, 0}, {0, 6, 0}, 0.1);
  const Occluders occluders(octree_of(points), {});
  std::vector<SkyTarget> wall{target_near(occluders, points, {3, 0, 1.5})};
  EXPECT_NEAR(view_of(occluders, wall.front(), {512}), 0.5, k_tolerance);
  find_open_sides(occluders, 64, wall);
  EXPECT_TRUE(wall.front().is_front_open);
  EXPECT_GT(wall.front().normal.x, 0.99);
  EXPECT_NEAR(view_of(occluders, wall.front(), {512}), 0.5, k_tolerance);
  const SkyTarget inside = target_near(occluders, points, {3, 0, 1.5}, glm::dvec3(-1, 0, 0));
  EXPECT_NEAR(view_of(occluders, inside, {512}), 0.0, k_tolerance);
}

TEST(SkyView, normals_point_outside) {
  Points points;
  add_rectangle(points, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, 0.1);
  const Occluders occluders(octree_of(points), {});
  EXPECT_NEAR(view_of(occluders, target_near(occluders, points, {0, 0, 0}, glm::dvec3(0, 0, 2)), {}), 1.0,
              1e-6);
  EXPECT_EQ(view_of(occluders, target_near(occluders, points, {0, 0, 0}, glm::dvec3(0, 0, -2)), {}), 0.0f);
}

TEST(SkyView, does_not_depend_on_threads_and_instruction_set) {
  const Points points = canyon(4.0, 6.0);
  const Octree octree = octree_of(points);
  const auto views = [&](InstructionSet set) {
    const Occluders occluders(octree.with_instruction_set(set), {});
    std::vector<SkyTarget> targets;
    for (std::size_t i = 0; i < points.size(); i += 499)
      targets.push_back(target_on_point(occluders, i, points[i], {}));
    std::vector<float> found(targets.size());
    sky_views(occluders, targets, {32}, found);
    return found;
  };
  const std::vector<float> usual = views(InstructionSet::best);
  EXPECT_EQ(views(InstructionSet::scalar), usual);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(views(InstructionSet::best), usual);
}

TEST(SkyView, number_of_directions_is_limited) {
  const Occluders occluders(octree_of({{1, 0, 0}}), {.radius = 0.1});
  EXPECT_THROW(view_of(occluders, {}, {0}), Error);
  EXPECT_THROW(view_of(occluders, {}, {k_most_sky_directions + 1}), Error);
  EXPECT_THROW(sky_shares(occluders, {}, 0), Error);
}

TEST(SkyDirections, are_spread_by_their_densities) {
  constexpr int k_count = 1000;
  double height = 0.0, height_sq = 0.0, lean = 0.0;
  for (const glm::dvec3& direction : even_sky_directions(k_count)) {
    EXPECT_NEAR(glm::length(direction), 1.0, 1e-12);
    EXPECT_GT(direction.z, 0.0);
    height += direction.z / k_count;
    lean += direction.x / k_count;
  }
  EXPECT_NEAR(height, 0.5, 1e-12);
  EXPECT_NEAR(lean, 0.0, 2e-3);
  for (const glm::dvec3& direction : cosine_sky_directions(k_count)) {
    EXPECT_NEAR(glm::length(direction), 1.0, 1e-12);
    height_sq += direction.z * direction.z / k_count;
  }
  EXPECT_NEAR(height_sq, 0.5, 1e-12);
}

}  // namespace
}  // namespace alidade::test
