// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "mesh/triangle_tree.h"
#include "renderer/world.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace renderer;

namespace {

/// A level roof of 4 m x 4 m at a height of 3 m.
Model roof(const glm::dvec3& offset = glm::dvec3(0.0)) {
  TriangleMesh mesh;
  for (const glm::dvec3 corner : {glm::dvec3(0, 0, 3), {4, 0, 3}, {4, 4, 3}, {0, 4, 3}})
    mesh.vertices.push_back(offset + corner);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_colors = {Rgb(0.5f, 0.25f, 0.0f), Rgb(0.5f, 0.25f, 0.0f)};
  return {std::make_shared<TriangleTree>(std::move(mesh)), "roof"};
}

TEST(Model, mesh_and_points_are_met_at_their_depths_and_shade_each_other) {
  // A point above the roof and one below it.
  const LoadedCloud cloud = test::loaded({{1, 1, 6}, {3, 2, 1}}, 0.5);
  Scene scene;
  scene.cloud.emplace();
  scene.objects = {roof()};
  const World world(scene, &cloud);
  const auto depth = [&](double x, double y) {
    const auto met = world.nearest(make_ray({x, y, 10}, {0, 0, -1}, 0.0), {});
    return met ? met->t : -1.0;
  };
  EXPECT_NEAR(depth(1, 1), 3.5, 1e-8);
  EXPECT_NEAR(depth(3, 2), 7.0, 1e-8);
  EXPECT_EQ(depth(5, 2), -1.0);
  const Ray down = make_ray({3, 2, 10}, {0, 0, -1}, 0.0);
  const Surface surface = world.surface_at(down, *world.nearest(down, {}));
  EXPECT_EQ(surface.normal, glm::dvec3(0, 0, 1));
  EXPECT_EQ(surface.color, Rgb(0.5f, 0.25f, 0.0f));
  // To a sun in the zenith: the mesh shades what is below it, the upper point shades the mesh.
  const auto is_shaded = [&](const glm::dvec3& from, const RayOrigin& origin) {
    return world.blocked(make_ray(from, {0, 0, 1}, 0.0), origin);
  };
  const RayOrigin on_mesh{.from = RayOrigin::From::object, .index = 0};
  EXPECT_TRUE(is_shaded({3, 2, 1.6}, {}));
  EXPECT_TRUE(is_shaded({1, 1, 3}, on_mesh));
  EXPECT_FALSE(is_shaded({3, 2, 3}, on_mesh));
  EXPECT_FALSE(is_shaded({5, 2, 1.6}, {}));
}

TEST(Model, blocks_what_is_beyond_it_and_nothing_at_its_distance) {
  Scene scene;
  scene.objects = {roof()};
  const World world(scene, nullptr);
  const Ray up = make_ray({3, 2, 1}, {0, 0, 1}, 0.0);
  const auto is_blocked = [&](double reach) {
    const RayOrigin in_air;
    std::uint8_t answer = 0;
    world.blocked({&up, 1}, {&in_air, 1}, {&answer, 1}, reach);
    return answer != 0;
  };
  const double t = world.nearest(up, {})->t;
  EXPECT_TRUE(is_blocked(std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(is_blocked(std::nextafter(t, 3.0)));
  EXPECT_FALSE(is_blocked(t));
  EXPECT_FALSE(is_blocked(0.0));
}

}  // namespace
}  // namespace alidade
