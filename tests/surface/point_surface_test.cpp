// SPDX-License-Identifier: MIT
#include "surface/point_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "octree/build.h"
#include "octree/spacing.h"
#include "surface/packed_surface.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::Random;

/// Steps of a tenth of a millimetre around UTM-like coordinates.
PointCloud empty_cloud() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-4), .offset = {690000.0, 5325000.0, 600.0}};
  return cloud;
}

void add(PointCloud& cloud, const glm::dvec3& position) {
  cloud.positions.emplace_back(glm::round(position / cloud.lattice.scale));
}

Octree with_all(const PointCloud& cloud) {
  return with_surfaces(with_spacings(build(cloud), 8));
}

/// Near enough to a normal distribution: the sum of twelve even ones.
double bell(Random& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random.unit();
  return sum;
}

/// Points on a square of 4 m, 5 cm from each other on average, with noise along its normal.
struct Square {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double noise = 0.0;
};

void add(PointCloud& cloud, const Square& square, Random& random, const glm::dvec3& corner = {}) {
  const glm::dvec3 side =
      std::fabs(square.normal.x) < 0.9 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 u = glm::normalize(glm::cross(square.normal, side)), v = glm::cross(square.normal, u);
  for (int i = 0; i < 6400; ++i) {
    add(cloud, corner + random.between(-2.0, 2.0) * u + random.between(-2.0, 2.0) * v +
                   square.noise * bell(random) * square.normal);
  }
}

/// Points of a noisy plane have its normal, and the middle of each disc is nearer to it than the point.
void expect_plane(const glm::dvec3& normal) {
  for (const double noise : {0.0, 0.002, 0.01}) {
    SCOPED_TRACE(noise);
    Random random("noisy_plane");
    PointCloud cloud = empty_cloud();
    add(cloud, Square{normal, noise}, random);
    const Octree octree = with_all(cloud);
    double squares = 0.0;
    std::size_t inside = 0, thin = 0, tilted = 0;
    for (std::size_t id = 0; id < cloud.size(); ++id) {
      const glm::dvec3 position = cloud.world(id) - cloud.lattice.offset;
      const PointSurface surface = surface_of(octree.layers(), id);
      ASSERT_TRUE(surface.exists) << id;
      if (glm::length(position) > 1.5) continue;
      ++inside;
      const glm::dvec3 center = position - surface.height * surface.normal;
      squares += glm::dot(center, normal) * glm::dot(center, normal);
      tilted += std::fabs(glm::dot(surface.normal, normal)) < 0.94 ? 1 : 0;
      ASSERT_LT(surface.thickness, 2.5 * noise + 2e-4) << id;
      thin += surface.thickness < 0.4 * noise ? 1 : 0;
    }
    EXPECT_LT(thin, inside / 100);
    EXPECT_LT(tilted, inside / 500);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(inside)), 0.45 * noise + 1e-4);
  }
}

TEST(PointSurface, of_a_noisy_plane_is_that_plane) {
  // Of walls, too: there the fit may find either normal, and the upper one is stored.
  for (const glm::dvec3& normal : {glm::dvec3(0.3, -0.5, 0.8), glm::dvec3(-0.8, 0.5, 0.3),
                                   glm::dvec3(0.7, 0.6, -0.2), glm::dvec3(0.2, 0.9, 0.1)}) {
    SCOPED_TRACE(normal.x);
    expect_plane(glm::normalize(normal));
  }
}

TEST(PointSurface, tells_the_two_sides_of_a_thin_plate_apart) {
  for (const double noise : {0.0, 0.00005}) {
    Random random("thin_plate");
    PointCloud cloud = empty_cloud();
    add(cloud, Square{{0.0, 0.0, 1.0}, noise}, random);
    const std::size_t front_count = cloud.size();
    add(cloud, Square{{0.0, 0.0, 1.0}, noise}, random, {0.0, 0.0, 0.001});
    const Octree octree = with_all(cloud);
    std::size_t inside = 0, mixed = 0;
    for (std::size_t id = 0; id < cloud.size(); ++id) {
      const glm::dvec3 position = cloud.world(id) - cloud.lattice.offset;
      if (std::fabs(position.x) > 1.8 || std::fabs(position.y) > 1.8) continue;
      const PointSurface surface = surface_of(octree.layers(), id);
      ASSERT_TRUE(surface.exists) << id;
      const double sheet = position.z - surface.height * surface.normal.z;
      ++inside;
      const bool right =
          std::fabs(sheet - (id < front_count ? 0.0 : 0.001)) < 0.0003 && surface.thickness < 0.0003;
      mixed += right ? 0 : 1;
    }
    // Chance lets both sides look like one here and there.
    EXPECT_LT(mixed, inside / 50) << noise;
  }
}

TEST(PointSurface, is_none_where_points_fill_space_or_stand_on_a_wire) {
  Random random("foliage_and_wire");
  PointCloud cloud = empty_cloud();
  for (int i = 0; i < 8000; ++i)
    add(cloud, {random.between(0.0, 1.0), random.between(0.0, 1.0), random.between(0.0, 1.0)});
  const std::size_t foliage = cloud.size();
  for (int i = 0; i < 1000; ++i) add(cloud, {10.0, 0.002 * i, 3.0});
  const Octree octree = with_all(cloud);
  std::size_t leaves = 0;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const bool exists = surface_of(octree.layers(), id).exists;
    if (id >= foliage) {
      ASSERT_FALSE(exists) << id;
    } else {
      leaves += exists ? 1 : 0;
    }
  }
  // Chance makes a flat neighbourhood here and there, and the outermost points have neighbours on one side.
  EXPECT_LT(leaves, foliage / 10);
}

TEST(PointSurface, is_none_of_a_bird_above_a_field_nor_of_a_few) {
  Random random("birds");
  PointCloud cloud = empty_cloud();
  add(cloud, Square{{0.0, 0.0, 1.0}, 0.002}, random);
  const std::size_t field = cloud.size();
  add(cloud, {0.5, 0.5, 0.3});
  for (const double x : {0.0, 0.02, 0.04}) add(cloud, {-0.7 + x, 0.2 - x * x, 0.4});
  const Octree octree = with_all(cloud);
  for (std::size_t id = field; id < cloud.size(); ++id)
    EXPECT_FALSE(surface_of(octree.layers(), id).exists) << id;
}

TEST(PointSurface, has_the_same_bits_on_every_instruction_set) {
  for (const test::PointFamily& family : test::point_families()) {
    if (family.cloud.size() == 0) continue;
    std::vector<std::uint32_t> expected;
    std::vector<std::uint8_t> expected_edges;
    for (const InstructionSet set : available_instruction_sets()) {
      const Octree fitted = with_surfaces(with_spacings(build(family.cloud).with_instruction_set(set), 8));
      const std::span<const std::uint32_t> found(fitted.layers().surfaces, fitted.size());
      const std::span<const std::uint8_t> edges(fitted.layers().sheet_edges, fitted.size());
      if (expected.empty()) {
        expected.assign(found.begin(), found.end());
        expected_edges.assign(edges.begin(), edges.end());
      }
      ASSERT_TRUE(std::ranges::equal(found, expected)) << family.name;
      ASSERT_TRUE(std::ranges::equal(edges, expected_edges)) << family.name;
    }
  }
}

TEST(PointSurface, of_an_octree_that_has_them_is_not_fitted_again) {
  Random random("fitted_once");
  PointCloud cloud = empty_cloud();
  add(cloud, Square{}, random);
  const Octree octree = with_all(cloud);
  EXPECT_EQ(with_surfaces(octree).layers().surfaces, octree.layers().surfaces);
}

TEST(PackedNormal, is_good_to_0_14_degrees_and_upright_stays_upright) {
  Random random;
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 normal = glm::normalize(random.direction());
    const glm::dvec3 packed =
        unpack_normal(pack_normal(normal, packed_surface::k_side_steps), packed_surface::k_side_steps);
    ASSERT_NEAR(glm::length(packed), 1.0, 1e-12);
    worst = std::max(worst, glm::length(glm::cross(packed, normal)));
  }
  EXPECT_LT(worst, glm::radians(0.14));
  EXPECT_EQ(
      unpack_normal(pack_normal({0, 0, -1}, packed_surface::k_side_steps), packed_surface::k_side_steps),
      glm::dvec3(0, 0, 1));
}

}  // namespace
}  // namespace alidade
