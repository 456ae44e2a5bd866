// SPDX-License-Identifier: MIT
#include "surface/disc_reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "octree/build.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/decide_point.h"
#include "tests/support/octrees.h"
#include "tests/support/random.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::Random;

/// How far a ray of the query meets a point from it along each axis.
glm::dvec3 reach_of_point(const SurfaceView& view, const SurfaceQuery& query, std::uint32_t index) {
  const double radius = own_radius(query, spacing_at(view.layers, index));
  const PointSurface surface = unpack_surface(view.stored_surfaces[index], view.layers.surface_unit);
  if (!surface.exists) return glm::dvec3(lone_radius(query, radius));
  glm::dvec3 reach;
  for (int axis = 0; axis < 3; ++axis) {
    // Of the points within the radius that are on the plane, the one that lies farthest along the axis.
    const double height = surface.height * surface.normal[axis], tilt = surface.normal[axis];
    const double across_sq = radius * radius - surface.height * surface.height;
    reach[axis] = across_sq < 0.0 ? 0.0 : std::fabs(height) + std::sqrt(across_sq * (1.0 - tilt * tilt));
  }
  return reach;
}

/// Checks the slots of a node and of those below. Returns the greatest reaches below it.
glm::dvec3 expect_reaches(const SurfaceView& view, const SurfaceQuery& query, const Frame& frame) {
  glm::dvec3 greatest(0.0);
  for (int slot = 0; slot < k_node_width; ++slot) {
    const std::uint8_t kind = view.tree.nodes[frame.node].kind[slot];
    glm::dvec3 below(0.0);
    if (is_inner(kind)) below = expect_reaches(view, query, child_frame(view.tree, frame, slot));
    if (is_leaf(kind)) {
      const Leaf leaf = child_leaf(view.tree, frame, slot);
      for (std::uint32_t i = 0; i < leaf.count; ++i)
        below = glm::max(below, reach_of_point(view, query, leaf.first + i));
    }
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t row = std::size_t{3} * frame.node + static_cast<std::size_t>(axis);
      const double stored =
          spacing_of(view.slot_reaches[k_node_width * row + static_cast<std::size_t>(slot)]);
      // Roundings are what the boxes have a margin for.
      const double widened = std::min(query.radius, disc_reach_factor(query) * stored);
      EXPECT_GE(widened * (1.0 + 1e-9), below[axis]);
    }
    greatest = glm::max(greatest, below);
  }
  return greatest;
}

class DiscReach : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(DiscReach, holds_what_rays_meet_of_all_points_below_a_slot) {
  for (const test::DiscCase& disc_case : test::disc_cases()) {
    if (disc_case.cloud.size() == 0) continue;
    Random random(disc_case.name + "_reaches");
    for (const test::NamedOctree& named : test::octrees_of(disc_case.cloud, GetParam())) {
      SCOPED_TRACE(disc_case.name + " " + named.name);
      const SurfaceCloud cloud = SurfaceCloud::of_discs(disc_case.with_all(named.octree));
      const double radius = automatic_radius(cloud.octree()) * std::pow(10.0, random.between(-1.0, 3.0));
      const SurfaceQuery query = test::disc_query({.radius = radius}, random);
      expect_reaches(cloud.view(), query, root_frame(cloud.view().tree));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, DiscReach, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

/// The greatest stored one of a cloud along an axis.
float greatest_reach(const SurfaceCloud& cloud, int axis) {
  const std::uint16_t* const row = cloud.view().slot_reaches + k_node_width * axis;
  return spacing_of(*std::max_element(row, row + k_node_width));
}

SurfaceCloud discs_of(const std::vector<glm::dvec3>& points) {
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-4), glm::dvec3(0)});
  return SurfaceCloud::of_discs(with_surfaces(with_spacings(build(cloud), k_surface_neighbours)));
}

TEST(DiscReaches, of_a_level_floor_are_flat) {
  Random random("flat_floor");
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(random.between(0, 10), random.between(0, 10), 0.0);
  const SurfaceCloud floor = discs_of(points);
  EXPECT_GT(greatest_reach(floor, 0), 0.1f);
  EXPECT_LT(greatest_reach(floor, 2), 0.01f * greatest_reach(floor, 0));
}

TEST(DiscReaches, of_a_point_without_a_sheet_are_that_of_its_small_sphere) {
  // A bird above a field, in a leaf of its own.
  std::vector<glm::dvec3> points;
  for (int x = 0; x < 40; ++x)
    for (int y = 0; y < 40; ++y) points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  points.emplace_back(2.0, 2.0, 40.0);
  const SurfaceCloud field = discs_of(points);
  for (std::uint32_t index = 0; index < field.size(); ++index)
    EXPECT_EQ(field.surface_at(index).exists, spacing_at(field.view().layers, index) < 30.0);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(greatest_reach(field, axis), 0.28 * 40.0, 0.2) << axis;
}

TEST(DiscReaches, are_not_known_where_surfaces_are_fitted_on_demand) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}, {1, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
  EXPECT_EQ(SurfaceCloud::of_discs(with_spacings(build(cloud), 1)).view().slot_reaches, nullptr);
}

}  // namespace
}  // namespace alidade
