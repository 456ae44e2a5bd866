// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "renderer/integrator.h"
#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

namespace alidade {

using namespace geo;
using namespace renderer;

namespace {

using test::camera_at;
using test::dark_scene;

TEST(Path, brings_back_the_same_alone_and_among_others) {
  test::Random random;
  std::vector<glm::dvec3> heap;
  for (int i = 0; i < 3000; ++i) heap.push_back(random.in_cube());
  const LoadedCloud cloud = test::loaded(heap, 0.05);
  Scene scene = dark_scene(camera_at({0, 0, 6}, {0, 0, 0}, 40.0), 1, 8);
  scene.sky = ConstantSky{Rgb(0.2f)};
  scene.sun = Sun{};
  scene.objects = {Sphere{{2, 0, 0}, 0.5, Emissive{Rgb(3.0f)}},
                   Sphere{{-2, 0, 0}, 0.5, Metal{Rgb(0.9f), 0.2}}, Sphere{{0, 2, 0}, 0.5, Dielectric{1.5}},
                   GroundPlane{-1.0, Lambertian{Rgb(0.5f)}}};
  const World world(scene, &cloud);
  const Lights lights(scene);
  std::vector<CameraPath> paths;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const glm::dvec3 target = 2.0 * random.in_cube();
    paths.push_back({make_ray({0, 0, 6}, target - glm::dvec3(0, 0, 6), 0.0), Sampler(1, i, 0, 0)});
  }
  std::vector<PathResult> together(paths.size());
  trace_paths(world, lights, paths, 8, together);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    PathResult alone;
    trace_paths(world, lights, {&paths[i], 1}, 8, {&alone, 1});
    EXPECT_EQ(alone.radiance, together[i].radiance) << i;
    EXPECT_EQ(alone.met_surface, together[i].met_surface) << i;
    EXPECT_EQ(alone.ray_count, together[i].ray_count) << i;
  }
}

}  // namespace
}  // namespace alidade
