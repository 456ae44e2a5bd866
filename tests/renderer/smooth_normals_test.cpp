// SPDX-License-Identifier: MIT
#include "renderer/world.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "renderer/sampling.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace renderer;

namespace {

const Lattice k_lattice{glm::dvec3(0.0001), {690000.0, 5325000.0, 500.0}};

LocalPlane normal_of_first(const std::vector<glm::dvec3>& offsets, double reach) {
  std::vector<glm::dvec3> positions;
  for (const glm::dvec3& offset : offsets) positions.push_back(k_lattice.offset + offset);
  const Octree octree = build(test::make_cloud(positions, k_lattice));
  return SmoothNormals(octree).at(0, positions[0], reach);
}

TEST(SmoothNormals, points_on_a_plane_have_its_normal_and_full_trust) {
  test::Random random;
  for (int round = 0; round < 200; ++round) {
    const Basis basis = basis_around(glm::normalize(random.direction()));
    std::vector<glm::dvec3> offsets{glm::dvec3(0.0)};
    for (int i = 0; i < 400; ++i) {
      offsets.push_back(
          basis.to_world({random.between(-1, 1), random.between(-1, 1), random.between(-0.002, 0.002)}));
    }
    const LocalPlane found = normal_of_first(offsets, 0.5);
    ASSERT_GT(std::abs(glm::dot(found.normal, basis.normal)), 1.0 - 1e-5);
    ASSERT_NEAR(glm::length(found.normal), 1.0, 1e-12);
    ASSERT_EQ(found.trust, 1.0);
  }
}

TEST(SmoothNormals, dense_leaves_that_speak_for_each_other_give_the_same_normal) {
  test::Random random;
  const Basis basis = basis_around(glm::normalize(glm::dvec3(1, 2, 3)));
  std::vector<glm::dvec3> offsets{glm::dvec3(0.0)};
  for (int i = 0; i < 50000; ++i) {
    offsets.push_back(
        basis.to_world({random.between(-1, 1), random.between(-1, 1), random.between(-0.01, 0.01)}));
  }
  EXPECT_GT(std::abs(glm::dot(normal_of_first(offsets, 0.8).normal, basis.normal)), 1.0 - 1e-5);
}

TEST(SmoothNormals, what_is_no_surface_has_little_trust_or_none) {
  test::Random random;
  EXPECT_EQ(normal_of_first({glm::dvec3(0.0)}, 1.0).trust, 0.0);
  EXPECT_EQ(normal_of_first({glm::dvec3(0.0), glm::dvec3(0.1)}, 1.0).trust, 0.0);
  EXPECT_EQ(normal_of_first(std::vector<glm::dvec3>(50, glm::dvec3(0.0)), 1.0).trust, 0.0);
  std::vector<glm::dvec3> row, heap{glm::dvec3(0.0)};
  for (int i = 0; i < 50; ++i) row.push_back({0.01 * i, 0.02 * i, -0.01 * i});
  for (int i = 0; i < 5000; ++i) heap.push_back(random.in_cube());
  EXPECT_EQ(normal_of_first(row, 1.0).trust, 0.0);
  EXPECT_LT(normal_of_first(heap, 0.8).trust, 0.1);
}

TEST(SmoothNormals, rays_leave_a_point_as_far_above_its_sphere_as_its_surface_is_trusted) {
  // Five points of a plane are too few to be sure of it.
  const LoadedCloud cloud =
      test::loaded({{0, 0, 0}, {0.1, 0, 0}, {-0.1, 0, 0}, {0, 0.1, 0}, {0, -0.1, 0}}, 0.06);
  const double trust = SmoothNormals(cloud.octree).at(0, {0, 0, 0}, 2.5 * 0.06).trust;
  EXPECT_GT(trust, 0.1);
  EXPECT_LT(trust, 0.9);
  Scene scene;
  scene.cloud.emplace().normals = NormalMode::smooth;
  const World world(scene, &cloud);
  const Ray ray = make_ray({0, 0, 5}, {0, 0, -1});
  const Surface surface = world.surface_at(ray, world.nearest(ray, {}).value());
  // From its top on to a quarter of a radius above it.
  EXPECT_NEAR(surface.ray_origin.z, 0.06 * (1.0 + 0.25 * trust), 1e-9);
}

TEST(SmoothNormals, points_out_of_reach_do_not_count) {
  std::vector<glm::dvec3> offsets;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) offsets.push_back({0.01 * i, 0.01 * j, 0.0});
  }
  std::swap(offsets.front(), offsets[offsets.size() / 2]);
  for (int i = 0; i < 500; ++i) offsets.push_back({0.0, 0.001 * i, 0.2});
  EXPECT_EQ(std::abs(normal_of_first(offsets, 0.15).normal.z), 1.0);
}

}  // namespace
}  // namespace alidade
