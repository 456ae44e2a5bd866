// SPDX-License-Identifier: MIT
#include "renderer/load_cloud.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "octree/spacing.h"
#include "renderer/integrator.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace renderer;

namespace {

constexpr double k_dense_step = 0.02, k_sparse_step = 0.4;

/// The floor of a room: scanned densely on one side, sparsely on the other.
std::vector<glm::dvec3> floor_of_two_densities() {
  std::vector<glm::dvec3> positions;
  for (int x = 0; x < 50; ++x)
    for (int y = 0; y < 50; ++y) positions.emplace_back(-2.0 + k_dense_step * x, k_dense_step * y, 0.0);
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y) positions.emplace_back(1.0 + k_sparse_step * x, k_sparse_step * y, 0.0);
  return positions;
}

CloudSettings adapted(const AdaptedRadius& radius) {
  CloudSettings settings;
  settings.adapted_radius = radius;
  return settings;
}

LoadedCloud floor_with(const CloudSettings& settings) {
  LoadedCloud cloud = test::loaded(floor_of_two_densities(), 0.0);
  choose_radius(settings, cloud);
  return cloud;
}

TEST(PointRadius, adapted_spheres_close_what_is_sparse_and_stay_small_where_it_is_dense) {
  const LoadedCloud cloud = floor_with(adapted({.neighbours = 4, .factor = 0.75}));
  Scene scene = test::dark_scene(test::camera_at({0, 0, 5}, {0, 0, 0}, 50), 1, 0);
  scene.cloud.emplace();
  const World world(scene, &cloud);
  const auto height_below = [&](double x, double y) {
    const Ray ray = make_ray({x, y, 5.0}, {0.0, 0.0, -1.0}, 0.0);
    const auto met = world.nearest(ray, {});
    return met ? 5.0 - met->t : -1.0;
  };
  // Over a point, the sphere's top; between four of them, still a sphere: half a diagonal is 0.71 steps.
  EXPECT_NEAR(height_below(-1.5, 0.5), 0.75 * k_dense_step, 0.01 * k_dense_step);
  EXPECT_NEAR(height_below(3.0, 2.0), 0.75 * k_sparse_step, 0.01 * k_sparse_step);
  EXPECT_GT(height_below(3.0 + 0.5 * k_sparse_step, 2.0 + 0.5 * k_sparse_step), 0.0);
  EXPECT_GT(height_below(-1.5 + 0.5 * k_dense_step, 0.5 + 0.5 * k_dense_step), 0.0);
  EXPECT_EQ(height_below(0.0, 3.0), -1.0);
}

TEST(PointRadius, no_sphere_is_larger_than_requested) {
  const LoadedCloud cloud = floor_with(adapted({.neighbours = 4, .factor = 0.75, .max = 0.1}));
  EXPECT_EQ(cloud.radius, 0.1);
  const auto dense = sphere_around(cloud, {-1.5, 0.5, 0.001}, k_all_levels);
  const auto sparse = sphere_around(cloud, {3.0, 2.0, 0.001}, k_all_levels);
  ASSERT_TRUE(dense && sparse);
  EXPECT_NEAR(dense->radius, 0.75 * k_dense_step, 0.01 * k_dense_step);
  EXPECT_NEAR(sparse->radius, 0.1, 1e-9);
}

TEST(PointRadius, without_a_limit_it_is_four_times_the_automatic_radius) {
  const LoadedCloud cloud = floor_with(adapted({}));
  EXPECT_EQ(cloud.radius, 4.0 * automatic_radius(cloud.octree));
  EXPECT_EQ(cloud.spacing_factor, 0.75);
  EXPECT_EQ(cloud.octree.layers().spacing_neighbours, 8);
}

TEST(PointRadius, a_radius_for_all_needs_no_spacings) {
  CloudSettings settings;
  settings.radius = 0.3;
  const LoadedCloud cloud = floor_with(settings);
  EXPECT_EQ(cloud.radius, 0.3);
  EXPECT_EQ(cloud.spacing_factor, 0.0);
  EXPECT_EQ(cloud.octree.layers().spacings, nullptr);
  EXPECT_EQ(floor_with(CloudSettings{}).radius, automatic_radius(cloud.octree));
}

TEST(PointRadius, a_position_is_inside_the_sphere_of_a_point_by_the_radius_of_that_point) {
  const LoadedCloud cloud = floor_with(adapted({.neighbours = 4, .factor = 0.75}));
  EXPECT_TRUE(sphere_around(cloud, {3.0, 2.0, 0.2}, k_all_levels));
  EXPECT_FALSE(sphere_around(cloud, {-1.5, 0.5, 0.2}, k_all_levels));
  EXPECT_TRUE(sphere_around(cloud, {-1.5, 0.5, 0.01}, k_all_levels));
  Scene scene = test::dark_scene(test::camera_at({3.0, 2.0, 0.2}, {0, 0, 0}, 50), 1, 0);
  scene.cloud.emplace();
  EXPECT_THROW(check_camera_position(*scene.camera, scene, cloud), Error);
  scene.camera = test::camera_at({-1.5, 0.5, 0.2}, {0, 0, 0}, 50);
  EXPECT_NO_THROW(check_camera_position(*scene.camera, scene, cloud));
}

TEST(PointRadius, a_glass_sphere_of_its_own_radius_is_left_where_it_ends) {
  const LoadedCloud cloud = floor_with(adapted({.neighbours = 4, .factor = 0.75}));
  Scene scene = test::dark_scene(test::camera_at({0, 0, 5}, {0, 0, 0}, 50), 1, 0);
  scene.cloud.emplace().material = Dielectric{1.5};
  const World world(scene, &cloud);
  const Ray down = make_ray({3.0, 2.0, 5.0}, {0.0, 0.0, -1.0}, 0.0);
  const auto top = world.nearest(down, {});
  ASSERT_TRUE(top);
  const RayOrigin inside{RayOrigin::From::point, top->index, top->center, true, top->radius};
  const auto bottom = world.nearest(make_ray({3.0, 2.0, 5.0 - top->t}, {0.0, 0.0, -1.0}, 0.0), inside);
  ASSERT_TRUE(bottom);
  EXPECT_NEAR(bottom->t, 2.0 * top->radius, 1e-9);
}

TEST(PointRadius, numbers_out_of_range_are_errors) {
  EXPECT_THROW(floor_with(adapted({.neighbours = 0})), Error);
  EXPECT_THROW(floor_with(adapted({.factor = 0.0})), Error);
  EXPECT_THROW(floor_with(adapted({.max = -1.0})), Error);
  CloudSettings settings;
  settings.radius = 0.0;
  EXPECT_THROW(floor_with(settings), Error);
}

TEST(PointRadius, adapted_radii_of_some_levels_are_an_error) {
  CloudSettings settings = adapted({});
  settings.max_level = 2;
  EXPECT_THROW(floor_with(settings), Error);
}

}  // namespace
}  // namespace alidade
