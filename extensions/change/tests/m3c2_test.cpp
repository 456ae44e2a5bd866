// SPDX-License-Identifier: MIT
#include "extensions/change/change.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "surface/local_plane.h"
#include "tests/support/random.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {
namespace {

using namespace visibility;

TEST(M3c2, a_surface_is_the_mean_of_its_points_in_the_cylinder) {
  Points points;
  for (const double z : {0.01, 0.02, 0.06}) points.emplace_back(0.05, 0.0, z);
  points.emplace_back(0.11, 0.0, 0.0);  // beside the cylinder
  points.emplace_back(0.0, 0.0, 0.5);   // beyond it
  const auto surface = nearest_surface(octree_of(points), {{0, 0, 0}, {0, 0, 1}, 0.1, 0.4, 0.1}, 0.0);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->count, 3u);
  EXPECT_NEAR(surface->t, 0.03, 1e-9);
  EXPECT_NEAR(surface->deviation, std::sqrt(0.0007), 1e-9) << "of a sample: divided by n - 1";
  EXPECT_NEAR(surface->middle.x, 0.05, 1e-9);
}

TEST(M3c2, of_several_surfaces_the_nearest_counts) {
  Points points;
  for (const double z : {0.100, 0.102, -0.201, -0.199}) points.emplace_back(0.0, 0.0, z);
  const Octree octree = octree_of(points);
  const Cylinder cylinder{{0, 0, 0}, {0, 0, 1}, 0.1, 0.4, 0.02};
  EXPECT_NEAR(nearest_surface(octree, cylinder, 0.0)->t, 0.101, 1e-9);
  EXPECT_NEAR(nearest_surface(octree, cylinder, -0.1)->t, -0.2, 1e-9);
  EXPECT_EQ(nearest_surface(octree, cylinder, 0.0, [&](std::uint64_t id) { return id > 1; })->count, 2u);
}

TEST(M3c2, an_empty_cylinder_has_no_surface) {
  EXPECT_FALSE(nearest_surface(octree_of({{0, 0, 1}}), {{0, 0, 0}, {0, 0, 1}, 0.1, 0.4, 0.1}, 0.0));
}

TEST(M3c2, the_level_of_detection_is_that_of_the_paper) {
  const CylinderSurface one{25, 0.0, 0.01, {}}, other{16, 0.0, 0.02, {}};
  EXPECT_NEAR(detection_level(one, other, 0.003),
              1.96 * (std::sqrt(0.01 * 0.01 / 25 + 0.02 * 0.02 / 16) + 0.003), 1e-15);
}

/// Hills with noise, at random positions.
Points hills(const char* seed, double lift) {
  Random random(seed);
  Points points;
  for (int i = 0; i < 6000; ++i) {
    const double x = random.between(0, 6), y = random.between(0, 6);
    points.emplace_back(x, y, 0.4 * std::sin(0.5 * x + 0.3 * y) + lift * x + random.between(-0.01, 0.01));
  }
  return points;
}

/// Mean along an axis of the points in a cylinder, their variance, and their number, by the formulas of the
/// paper.
struct PlainSurface {
  double mean = 0.0, variance = 0.0, count = 0.0;
};
PlainSurface plain_surface(const Points& points, const Cylinder& cylinder) {
  std::vector<double> heights;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 offset = point - cylinder.center;
    const double height = glm::dot(offset, cylinder.axis);
    if (std::fabs(height) <= cylinder.half_length &&
        glm::length(offset - height * cylinder.axis) <= cylinder.radius)
      heights.push_back(height);
  }
  PlainSurface surface{.count = static_cast<double>(heights.size())};
  surface.mean = std::accumulate(heights.begin(), heights.end(), 0.0) / surface.count;
  for (const double height : heights)
    surface.variance += (height - surface.mean) * (height - surface.mean) / (surface.count - 1.0);
  return surface;
}

TEST(M3c2, distances_are_those_of_plain_loops) {
  // Positions as the lattice has them.
  const auto on_lattice = [](Points points) {
    for (glm::dvec3& point : points) point = 0.0001 * glm::round(point / 0.0001);
    return points;
  };
  const Points before = on_lattice(hills("before", 0.0)), after = on_lattice(hills("after", 0.01));
  const Occluders old_occluders(octree_of(before), {}), new_occluders(octree_of(after), {});
  constexpr double k_normal_radius = 0.5, k_error = 0.002;
  const ChangeOptions options{.registration_error = k_error,
                              .normal_radius = k_normal_radius,
                              .cylinder_radius = 0.6,
                              .max_distance = 0.3};
  const Changes changes = find_changes({old_occluders, {}}, {new_occluders, {}}, options);
  std::size_t compared = 0;
  for (std::size_t id = 0; id < before.size(); id += 7) {
    if (std::isnan(changes.before.distances[id])) continue;
    glm::dvec3 normal = local_plane(old_occluders.octree(), before[id], k_normal_radius).normal;
    if (normal.z < 0.0) normal = -normal;
    const Cylinder cylinder{before[id], normal, 0.6, 0.3, 0.0};
    const PlainSurface one = plain_surface(before, cylinder), other = plain_surface(after, cylinder);
    const double level =
        1.96 * (std::sqrt(one.variance / one.count + other.variance / other.count) + k_error);
    ASSERT_NEAR(changes.before.distances[id], other.mean - one.mean, 1e-6) << id;
    ASSERT_NEAR(changes.before.detection_levels[id], level, 1e-6) << id;
    ASSERT_EQ(changes.before.classes[id],
              std::fabs(other.mean - one.mean) > level ? ChangeClass::moved : ChangeClass::same)
        << id;
    ++compared;
  }
  EXPECT_GT(compared, 700u);
}

}  // namespace
}  // namespace alidade::test
