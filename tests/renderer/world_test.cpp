// SPDX-License-Identifier: MIT
#include "renderer/world.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "octree/distance.h"
#include "renderer/sampling.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace renderer;

namespace {

const glm::dvec3 k_utm(690000.0, 5325000.0, 500.0);

TEST(Surface, a_point_is_met_where_its_analytic_sphere_is) {
  test::Random random;
  const LoadedCloud cloud = test::loaded({k_utm}, 0.25, {glm::dvec3(0.001), k_utm});
  Scene points, spheres;
  points.cloud.emplace();
  spheres.objects = {Sphere{k_utm, 0.25, Lambertian{}}};
  const World point_world(points, &cloud), sphere_world(spheres, nullptr);
  int met_count = 0;
  for (int i = 0; i < 5000; ++i) {
    const glm::dvec3 eye = k_utm + glm::normalize(random.direction()) * random.between(0.3, 50.0);
    const Ray ray = make_ray(eye, k_utm + random.in_cube() * 0.3 - eye, 0.0);
    const auto a = point_world.nearest(ray, {}), b = sphere_world.nearest(ray, {});
    // A ray that just touches may go either way.
    const double distance = project(ray, k_utm).distance;
    if (std::abs(distance - 0.25) < 1e-6) continue;
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ++met_count;
    ASSERT_TRUE(a->on_cloud);
    ASSERT_FALSE(b->on_cloud);
    const Surface on_point = point_world.surface_at(ray, *a), on_sphere = sphere_world.surface_at(ray, *b);
    ASSERT_NEAR(glm::length(on_point.position - on_sphere.position), 0.0, 2e-6);
    ASSERT_NEAR(glm::length(on_point.position - k_utm), 0.25, 1e-8);
    ASSERT_NEAR(glm::length(on_point.normal), 1.0, 1e-14);
  }
  EXPECT_GT(met_count, 1000);
}

TEST(Surface, the_nearer_of_point_and_object_wins) {
  const LoadedCloud cloud = test::loaded({{0, 0, 2}}, 0.5);
  Scene scene;
  scene.cloud.emplace();
  const auto nearest_is_point = [&](const Object& object) {
    scene.objects = {object};
    const auto met = World(scene, &cloud).nearest(make_ray({0, 0, 10}, {0, 0, -1}), {});
    return met && met->on_cloud;
  };
  EXPECT_TRUE(nearest_is_point(GroundPlane{0.0}));
  EXPECT_TRUE(nearest_is_point(GroundPlane{2.49}));
  EXPECT_FALSE(nearest_is_point(GroundPlane{2.51}));
  EXPECT_FALSE(nearest_is_point(Sphere{{0, 0, 4}, 0.5}));
  EXPECT_TRUE(nearest_is_point(Sphere{{0, 0, 2}, 0.499}));
  EXPECT_FALSE(nearest_is_point(Sphere{{0, 0, 2}, 0.501}));
}

TEST(Surface, a_ray_that_leaves_a_point_never_meets_it_again) {
  test::Random random;
  for (const double radius : {1e-3, 0.05, 2.0}) {
    const LoadedCloud cloud = test::loaded({k_utm}, radius, {glm::dvec3(0.001), k_utm});
    Scene scene;
    scene.cloud.emplace();
    const World world(scene, &cloud);
    for (int i = 0; i < 20000; ++i) {
      const glm::dvec3 eye =
          k_utm + glm::normalize(random.direction()) * random.between(2.0, 1000.0) * radius;
      const Ray ray = make_ray(eye, k_utm + random.in_cube() * 0.5 * radius - eye, 0.0);
      const auto met = world.nearest(ray, {});
      ASSERT_TRUE(met);
      const Surface surface = world.surface_at(ray, *met);
      const RayOrigin ray_origin{RayOrigin::From::point, met->index, met->center, false, met->radius};
      // From straight up to grazing within rounding.
      const double cosine = std::pow(10.0, random.between(-18.0, 0.0));
      const double sine = std::sqrt(1.0 - cosine * cosine), turns = random.unit();
      const SineCosine turn = sine_cosine_of_turns(turns);
      const glm::dvec3 direction =
          basis_around(surface.normal).to_world({sine * turn.cosine, sine * turn.sine, cosine});
      ASSERT_FALSE(world.nearest({surface.position, direction}, ray_origin)) << "cosine " << cosine;
      ASSERT_FALSE(world.blocked({surface.position, direction}, ray_origin)) << "cosine " << cosine;
    }
  }
}

TEST(Surface, a_ray_that_leaves_a_point_meets_its_neighbours) {
  const LoadedCloud cloud =
      test::loaded({k_utm, k_utm + glm::dvec3(0.12, 0, 0)}, 0.05, {glm::dvec3(0.001), k_utm});
  Scene scene;
  scene.cloud.emplace();
  const World world(scene, &cloud);
  const auto met = world.nearest(make_ray(k_utm + glm::dvec3(0.05, 0, 0), {1, 0, 0}), {});
  ASSERT_TRUE(met);
  EXPECT_EQ(met->index, 1u);
  EXPECT_NEAR(met->t, 0.02, 1e-8);
}

TEST(Surface, smallest_entry_is_far_below_the_radius_and_above_rounding) {
  for (const double magnitude : {0.0, 180.0, 5.3e6, 1e8}) {
    for (const double radius : {1e-3, 0.05, 3.0}) {
      const double entry = smallest_entry({glm::dvec3(-magnitude), glm::dvec3(magnitude)}, radius);
      EXPECT_GE(entry, 8.0 * std::numeric_limits<double>::epsilon() * magnitude);
      EXPECT_GT(entry, 0.0);
      EXPECT_LT(entry, 1e-3 * radius);
    }
  }
}

TEST(Surface, a_ray_that_leaves_an_object_never_meets_it_again_outside) {
  test::Random random;
  Scene scene;
  scene.objects = {Sphere{k_utm, 1000.0, Lambertian{}}};
  const World world(scene, nullptr);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 normal = glm::normalize(random.direction());
    const SineCosine turn = sine_cosine_of_turns(random.unit());
    const double cosine = std::pow(10.0, random.between(-18.0, 0.0)), sine = std::sqrt(1.0 - cosine * cosine);
    const glm::dvec3 direction =
        basis_around(normal).to_world({sine * turn.cosine, sine * turn.sine, cosine});
    const Ray ray{k_utm + 1000.0 * normal, direction};
    ASSERT_FALSE(world.nearest(ray, {RayOrigin::From::object, 0, {}, false}));
    ASSERT_FALSE(world.blocked(ray, {RayOrigin::From::object, 0, {}, false}));
  }
}

TEST(Surface, a_ray_inside_an_object_meets_its_far_wall) {
  Scene scene;
  scene.objects = {Sphere{k_utm, 10.0, Dielectric{}}};
  const World world(scene, nullptr);
  // A chord at 60 degrees to the normal is as long as the radius.
  const Ray ray{k_utm + glm::dvec3(0, 0, 10), {std::sqrt(0.75), 0.0, -0.5}};
  const auto met = world.nearest(ray, {RayOrigin::From::object, 0, {}, true});
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->t, 10.0, 1e-8);
  // A camera inside the sphere sees the wall too.
  EXPECT_NEAR(world.nearest(make_ray(k_utm, {0, 1, 0}), {})->t, 10.0, 1e-8);
}

TEST(Surface, inside_a_glass_point_only_its_own_far_wall_is_met) {
  const LoadedCloud cloud = test::loaded({{0, 0, 0}, {0, 0, 0.1}}, 1.0);
  Scene scene;
  scene.cloud.emplace();
  scene.cloud->material = Dielectric{};
  const World world(scene, &cloud);
  const auto met = world.nearest({{0, 0, 1}, {0, 0, -1}}, {RayOrigin::From::point, 0, {0, 0, 0}, true, 1.0});
  ASSERT_TRUE(met);
  EXPECT_EQ(met->index, 0u);
  EXPECT_NEAR(met->t, 2.0, 1e-12);
}

TEST(Surface, mode_t_takes_the_point_projected_first_and_mode_entry_the_sphere_entered_first) {
  // Seen from above: sphere 0 is met off its middle, so it is entered later although its centre projects
  // first.
  const LoadedCloud cloud = test::loaded({{0.9, 0, 0.1}, {0, 0, 0}}, 1.0);
  Scene scene;
  scene.cloud.emplace();
  const Ray ray = make_ray({0, 0, 10}, {0, 0, -1});
  EXPECT_EQ(World(scene, &cloud).nearest(ray, {})->index, 1u);
  scene.cloud->hits = HitMode::t;
  EXPECT_EQ(World(scene, &cloud).nearest(ray, {})->index, 0u);
}

TEST(Surface, point_colours_are_decoded_from_srgb_and_never_reflect_everything) {
  LoadedCloud cloud = test::loaded({{0, 0, 0}}, 1.0);
  cloud.colors = {Color16(0, 32896, 65535)};  // 0, 128/255, 1
  Scene scene;
  scene.cloud.emplace();
  const World world(scene, &cloud);
  const Ray ray = make_ray({0, 0, 10}, {0, 0, -1});
  const Rgb color = world.surface_at(ray, *world.nearest(ray, {})).color;
  EXPECT_EQ(color.r, 0.0f);
  EXPECT_NEAR(color.g, 0.2158605f, 1e-6f);
  EXPECT_EQ(color.b, 0.95f);
}

TEST(Surface, a_cloud_without_points_is_empty_space) {
  const LoadedCloud cloud = test::loaded({}, 1.0);
  Scene scene;
  scene.cloud.emplace();
  EXPECT_FALSE(World(scene, &cloud).nearest(make_ray({0, 0, 10}, {0, 0, -1}), {}));
  EXPECT_FALSE(World(scene, &cloud).blocked(make_ray({0, 0, 10}, {0, 0, -1}), {}));
}

}  // namespace
}  // namespace alidade
