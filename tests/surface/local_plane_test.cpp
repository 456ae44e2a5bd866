// SPDX-License-Identifier: MIT
#include "surface/local_plane.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <vector>

#include "octree/build.h"
#include "surface/simd/moments.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::PointFamily;
using test::Random;

/// A position among the points, and a reach that holds some of them.
struct Ball {
  glm::dvec3 position;
  double reach;
};

std::vector<Ball> positions_in(const PointCloud& cloud, std::size_t count, Random& random) {
  std::vector<Ball> balls;
  if (cloud.size() == 0) return balls;
  Bounds bounds;
  for (std::size_t id = 0; id < cloud.size(); ++id) bounds.grow(cloud.world(id));
  const double size = glm::length(bounds.size()) + glm::length(cloud.lattice.scale);
  for (std::size_t i = 0; i < count; ++i)
    balls.push_back(
        {cloud.world(random.below(cloud.size())), size * std::pow(10.0, random.between(-3.0, 0.3))});
  return balls;
}

/// The sums in double, point by point.
std::array<double, 11> sums_in_double(const PointCloud& cloud, const Ball& ball) {
  std::array<double, 11> sums{};
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const glm::dvec3 p = (cloud.world(id) - ball.position) / ball.reach;
    const double closeness = 1.0 - glm::dot(p, p);
    if (!(closeness > 0.0)) continue;
    const double w = closeness * closeness;
    const double values[11] = {w,
                               1.0,
                               w * p.x,
                               w * p.y,
                               w * p.z,
                               w * p.x * p.x,
                               w * p.x * p.y,
                               w * p.x * p.z,
                               w * p.y * p.y,
                               w * p.y * p.z,
                               w * p.z * p.z};
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += values[i];
  }
  return sums;
}

simd::BallPoints points_of(const TreeView& tree, InstructionSet set, const simd::Ball& ball) {
  simd::BallPoints points;
  simd::local_sums(set).gather(tree, ball, points);
  return points;
}

simd::Moments moments_of(const TreeView& tree, InstructionSet set, const Ball& ball) {
  return simd::local_sums(set).moments(points_of(tree, set, {ball.position, ball.reach}));
}

TEST(Moments, are_those_of_the_points_within_reach) {
  for (const PointFamily& family : test::point_families()) {
    Random random(family.name + "_moments");
    for (const test::NamedOctree& named : test::octrees_of(family.cloud)) {
      for (const Ball& ball : positions_in(family.cloud, 20, random)) {
        SCOPED_TRACE(family.name + " " + named.name);
        const auto expected = sums_in_double(family.cloud, ball);
        const simd::Moments found = moments_of(named.octree.view(), named.octree.instruction_set(), ball);
        // Floats resolve positions within a frame to 2^-24 of its width, which may be more in units of the
        // reach.
        const TreeView& tree = named.octree.view();
        const double frame = std::ldexp(glm::length(tree.lattice.scale), tree.root_level);
        const double error = expected[1] * (1e-5 + 1e-6 * frame / ball.reach);
        ASSERT_NEAR(found.weight, expected[0], error);
        for (std::size_t i = 0; i < 3; ++i) ASSERT_NEAR(found.first[i], expected[2 + i], error);
        for (std::size_t i = 0; i < 6; ++i) ASSERT_NEAR(found.second[i], expected[5 + i], error);
      }
    }
  }
}

TEST(Moments, are_the_same_bits_on_every_instruction_set) {
  for (const PointFamily& family : test::point_families()) {
    if (family.cloud.size() == 0) continue;
    const Octree octree = build(family.cloud);
    Random random(family.name + "_bits");
    for (const Ball& ball : positions_in(family.cloud, 100, random)) {
      const auto with = [&](InstructionSet set) { return moments_of(octree.view(), set, ball); };
      const simd::Moments scalar = with(InstructionSet::scalar);
      for (const InstructionSet set : available_instruction_sets()) {
        const simd::Moments found = with(set);
        ASSERT_EQ(std::memcmp(&found, &scalar, sizeof scalar), 0) << family.name << " " << name(set);
      }
    }
  }
}

const std::array<glm::vec2, packed_surface::k_edge_directions>& directions() {
  static const std::array<glm::vec2, packed_surface::k_edge_directions> all = [] {
    std::array<glm::vec2, packed_surface::k_edge_directions> made{};
    for (int i = 0; i < packed_surface::k_edge_directions; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / packed_surface::k_edge_directions;
      made[i] = {std::cos(angle), std::sin(angle)};
    }
    return made;
  }();
  return all;
}

/// All sums over a ball.
struct AllSums {
  simd::Moments around, within, beyond;
  simd::HeightSums heights;
  simd::Extents extents;
};

AllSums all_sums(const TreeView& tree, InstructionSet set, const simd::Ball& ball) {
  const simd::LocalSums& sums = simd::local_sums(set);
  const simd::Level level{glm::normalize(glm::vec3(0.2f, -0.1f, 1.0f)), 0.05f};
  const simd::Layer within{level, 0.3f}, beyond{level, 0.3f, simd::Layer::Side::beyond};
  const simd::Fan fan{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), directions(), 0.5f};
  const simd::BallPoints points = points_of(tree, set, ball);
  return {sums.moments(points), sums.of_layer(points, within), sums.of_layer(points, beyond),
          sums.heights(points, level), sums.extents(points, within, fan)};
}

TEST(LocalSums, are_the_same_bits_on_every_instruction_set_and_from_nodes_found_for_a_box) {
  static_assert(sizeof(AllSums) % sizeof(float) == 0);
  for (const PointFamily& family : test::point_families()) {
    Random random(family.name + "_nodes");
    for (const test::NamedOctree& named : test::octrees_of(family.cloud)) {
      SCOPED_TRACE(family.name + " " + named.name);
      const TreeView& tree = named.octree.view();
      for (const Ball& ball : positions_in(family.cloud, 20, random)) {
        const AllSums expected = all_sums(tree, InstructionSet::scalar, {ball.position, ball.reach});
        Bounds box;
        for (int corner = 0; corner < 2; ++corner) {
          const glm::dvec3 side(random.unit(), random.unit(), random.unit());
          box.grow(ball.position + (corner == 0 ? -ball.reach : ball.reach) * side);
        }
        const double reach = (1.0 + random.unit()) * ball.reach;
        for (const InstructionSet set : available_instruction_sets()) {
          std::vector<Frame> nodes;
          simd::local_sums(set).find_nodes(tree, box, reach, nodes);
          const AllSums alone = all_sums(tree, set, {ball.position, ball.reach});
          const AllSums together = all_sums(tree, set, {ball.position, ball.reach, &nodes});
          ASSERT_EQ(std::memcmp(&alone, &expected, sizeof expected), 0) << name(set);
          ASSERT_EQ(std::memcmp(&together, &expected, sizeof expected), 0) << name(set);
        }
      }
    }
  }
}

TEST(LocalSums, of_the_two_sides_of_a_layer_are_those_of_all_points) {
  for (const PointFamily& family : test::point_families()) {
    if (family.cloud.size() == 0) continue;
    const Octree octree = build(family.cloud);
    Random random(family.name + "_layers");
    for (const Ball& ball : positions_in(family.cloud, 50, random)) {
      const AllSums sums = all_sums(octree.view(), octree.instruction_set(), {ball.position, ball.reach});
      EXPECT_EQ(sums.within.count + sums.beyond.count, sums.around.count) << family.name;
      EXPECT_EQ(sums.heights.weight, sums.around.weight) << family.name;
    }
  }
}

/// As around a stray, whose neighbours are far away.
TEST(LocalSums, of_more_points_than_a_block_holds_are_those_of_all) {
  Random random("large_ball");
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(1e-3);
  for (int i = 0; i < 60000; ++i)
    cloud.positions.emplace_back(random.below(4000), random.below(4000), random.below(400));
  const Ball ball{{2.0, 2.0, 0.2}, 3.0};
  const std::array<double, 11> expected = sums_in_double(cloud, ball);
  ASSERT_EQ(expected[1], 60000.0);
  const AllSums scalar = all_sums(build(cloud).view(), InstructionSet::scalar, {ball.position, ball.reach});
  for (const InstructionSet set : available_instruction_sets()) {
    BuildOptions options;
    options.instruction_set = set;
    const Octree octree = build(cloud, options);
    const AllSums sums = all_sums(octree.view(), set, {ball.position, ball.reach});
    EXPECT_EQ(std::memcmp(&sums, &scalar, sizeof sums), 0) << name(set);
    EXPECT_EQ(sums.around.count, 60000.0f);
    EXPECT_EQ(sums.within.count + sums.beyond.count, 60000.0f);
    EXPECT_EQ(sums.heights.weight, sums.around.weight);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(sums.around.second[i], expected[5 + i], 1e-4 * expected[0]);
    for (const float extent : sums.extents) EXPECT_GT(extent, 0.5f);
    EXPECT_LE(points_of(octree.view(), set, {ball.position, ball.reach}).count,
              simd::BallPoints::k_most_in_block + k_max_leaf_size);
  }
}

/// Points far from others in a wide tree: no rounding of the wide frames loses one within reach.
TEST(LocalSums, count_every_point_within_reach_in_a_wide_tree) {
  Random random("wide_tree");
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(1e-3);
  for (int i = 0; i < 20000; ++i)
    cloud.positions.emplace_back(random.below(400), random.below(400), random.below(400));
  cloud.positions.emplace_back(1 << 30, 1 << 30, 1 << 30);
  const Octree octree = build(cloud);
  for (int i = 0; i < 500; ++i) {
    const Ball ball{cloud.world(random.below(20000)), random.between(0.003, 0.03)};
    double count = 0.0;
    bool at_reach = false;
    for (std::size_t id = 0; id < cloud.size(); ++id) {
      const double distance = glm::length(cloud.world(id) - ball.position) / ball.reach;
      at_reach = at_reach || std::fabs(distance - 1.0) < 1e-3;
      count += distance < 1.0 ? 1.0 : 0.0;
    }
    if (at_reach) continue;
    EXPECT_EQ(moments_of(octree.view(), octree.instruction_set(), ball).count, count);
  }
}

TEST(LocalPlane, of_points_on_an_inclined_plane_is_that_plane_at_utm_coordinates) {
  const glm::dvec3 site(690000.0, 5325000.0, 500.0), normal = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
  const glm::dvec3 u = glm::normalize(glm::cross(normal, glm::dvec3(1, 0, 0))), v = glm::cross(normal, u);
  Random random;
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 4000; ++i)
    points.push_back(site + random.between(-1, 1) * u + random.between(-1, 1) * v);
  // A stray a hundred kilometres away: frames become so large that coordinates of 16 bits are not exact.
  points.push_back(site + glm::dvec3(1e5, 1e5, 0.0));
  const Octree octree = build(test::make_cloud(points, {glm::dvec3(0.0001), site}));
  const LocalPlane found = local_plane(octree, site, 0.2);
  EXPECT_NEAR(std::fabs(glm::dot(found.normal, normal)), 1.0, 1e-5);
  EXPECT_NEAR(found.trust, 1.0, 1e-3);
  EXPECT_EQ(local_plane(octree, site + glm::dvec3(0.0, 0.0, 50.0), 0.2).trust, 0.0);
  EXPECT_EQ(local_plane(build(PointCloud()), site, 0.2).trust, 0.0);
}

/// Points about the origin, all as far away, so that they weigh the same.
LocalPlane plane_of_points(const std::vector<glm::dvec3>& points) {
  return local_plane(build(test::make_cloud(points, {glm::dvec3(1e-6), glm::dvec3(0.0)})), glm::dvec3(0.0),
                     2.0);
}

TEST(LocalPlane, trust_is_known_on_paper) {
  // Six more points than three make it certain.
  for (int count = 1; count <= 12; ++count) {
    std::vector<glm::dvec3> ring;
    for (int i = 0; i < count; ++i)
      ring.emplace_back(std::cos(6.283185307 * i / count), std::sin(6.283185307 * i / count), 0.0);
    EXPECT_NEAR(plane_of_points(ring).trust, count < 4 ? 0.0 : std::min(1.0, (count - 3) / 6.0), 1e-4)
        << count;
  }
  // Corners of a box, each taken twice: variances are the squares of half its sides.
  const auto corners = [](double x, double y, double z) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 16; ++i) points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
    return plane_of_points(points);
  };
  for (const double ratio : {0.0, 0.05, 0.1, 0.2, 0.3, 0.4}) {
    EXPECT_NEAR(corners(0.7, 0.7, 0.7 * std::sqrt(ratio)).trust, std::clamp((0.35 - ratio) / 0.29, 0.0, 1.0),
                1e-3)
        << "thickness " << ratio;
    // Long rows are broad from a tenth of their variance on.
    EXPECT_NEAR(corners(1.0, std::sqrt(ratio), 0.0).trust, std::min(1.0, ratio / 0.1), 1e-3)
        << "breadth " << ratio;
    // A cluster must be broad beside the reach of 2, too.
    EXPECT_NEAR(corners(0.2, 0.2 * std::sqrt(ratio), 0.0).trust, std::min(1.0, ratio * 0.01 / 0.02), 1e-3)
        << "breadth of a cluster " << ratio;
  }
}

/// Of points around a position that weigh the same.
simd::Moments even_moments(const std::vector<glm::dvec3>& points) {
  simd::Moments moments;
  for (const glm::dvec3& point : points) {
    const glm::vec3 p(point);
    moments.weight += 1.0f;
    moments.count += 1.0f;
    for (int i = 0; i < 3; ++i) moments.first[i] += p[i];
    const float products[6] = {p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z};
    for (int i = 0; i < 6; ++i) moments.second[i] += products[i];
  }
  return moments;
}

/// Variance of the points that add up to these moments, along a direction.
double variance_along(const simd::Moments& moments, const glm::dvec3& d) {
  const auto& s = moments.second;
  const double mean =
      (d.x * moments.first[0] + d.y * moments.first[1] + d.z * moments.first[2]) / moments.weight;
  const double square = d.x * d.x * s[0] + d.y * d.y * s[3] + d.z * d.z * s[5] +
                        2.0 * (d.x * d.y * s[1] + d.x * d.z * s[2] + d.y * d.z * s[4]);
  return square / moments.weight - mean * mean;
}

TEST(LocalPlane, faces_where_its_points_deviate_least) {
  Random random("least_variance");
  const auto direction = [&] {
    return glm::normalize(glm::dvec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)));
  };
  // Sides of the cluster: also flat ones, rows, balls, and those that lie along the axes.
  const double sides[] = {0.0, 1e-7, 1e-4, 1e-2, 0.3, 0.3, 1.0};
  for (int i = 0; i < 5000; ++i) {
    const glm::dvec3 u = i % 3 == 0 ? glm::dvec3(0, 0, 1) : direction();
    const PlaneAxes axes = axes_across(u);
    double lengths[3];
    for (double& length : lengths) length = sides[random.below(std::size(sides))];
    std::vector<glm::dvec3> points;
    for (std::size_t n = 4 + random.below(30); n > 0; --n)
      points.push_back(lengths[0] * random.between(-1, 1) * u +
                       lengths[1] * random.between(-1, 1) * axes.first +
                       lengths[2] * random.between(-1, 1) * axes.second);
    const simd::Moments moments = even_moments(points);
    const LocalPlane plane = plane_of(moments, 1.0);
    if (plane.count == 0.0) continue;
    const double least = variance_along(moments, plane.normal);
    const double widest = variance_along(moments, {1, 0, 0}) + variance_along(moments, {0, 1, 0}) +
                          variance_along(moments, {0, 0, 1});
    ASSERT_NEAR(glm::length(plane.normal), 1.0, 1e-12);
    ASSERT_NEAR(plane.thickness * plane.thickness, std::max(least, 0.0), 1e-12 * widest) << i;
    for (int j = 0; j < 20; ++j) {
      const glm::dvec3 other =
          glm::normalize(plane.normal + std::pow(10.0, random.between(-7, 1)) * direction());
      ASSERT_GE(variance_along(moments, other), least - 1e-12 * widest) << i;
    }
  }
}

TEST(LocalPlane, lies_where_its_points_do) {
  // Half a ring, 0.3 below the position: the mean of its points is beside it.
  std::vector<glm::dvec3> points;
  double beside = 0.0;
  for (int i = -4; i <= 4; ++i) {
    const double angle = 0.3 * i;
    points.emplace_back(std::cos(angle), std::sin(angle), -0.3);
    beside += std::cos(angle) / 9.0;
  }
  const LocalPlane plane = plane_of_points(points);
  EXPECT_NEAR(plane.height * plane.normal.z, 0.3, 1e-5);
  EXPECT_NEAR(plane.off_center, beside, 1e-5);
  EXPECT_NEAR(plane.thickness, 0.0, 1e-3);
  // A thick sheet that is tilted a little, by less than its points deviate from it.
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1e-4, 2e-4, 1.0));
  const glm::dvec3 u = glm::normalize(glm::cross(normal, {0, 1, 0})), v = glm::cross(normal, u);
  points.clear();
  for (int i = 0; i < 8; ++i)
    points.push_back((i & 1 ? 0.9 : -0.9) * u + (i & 2 ? 0.7 : -0.7) * v + (i & 4 ? 0.2 : -0.2) * normal);
  EXPECT_NEAR(glm::length(glm::cross(plane_of_points(points).normal, normal)), 0.0, 1e-5);
  EXPECT_NEAR(plane_of_points(points).thickness, 0.2, 1e-5);
}

}  // namespace
}  // namespace alidade
