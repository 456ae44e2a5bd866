// SPDX-License-Identifier: MIT
#pragma once

#include "tests/renderer/tracer_scenes.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

/// A little of everything.
inline Scene mixed_scene() {
  Scene scene;
  scene.camera = pinhole_from_fov(70, 50, 50.0, look_at({0, -6, 3}, {0, 0, 0.5}));
  scene.render = {.samples = 5, .max_bounces = 6, .seed = 42};
  scene.sun.emplace();
  scene.cloud.emplace();
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.4f)}}, Sphere{{2, 0, 1}, 0.7, Dielectric{1.5}},
                   Sphere{{-2, 0, 1}, 0.7, Metal{Rgb(0.9f), 0.3}},
                   Sphere{{0, 1, 3}, 0.3, Emissive{Rgb(5.0f)}}};
  return scene;
}

inline LoadedCloud mixed_cloud() {
  Random random("mixed cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) positions.push_back(random.in_cube() + glm::dvec3(0, 0, 1));
  return loaded(positions, 0.06);
}

inline void expect_same(const Film& a, const Film& b) {
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(a.alpha, b.alpha);
  EXPECT_EQ(a.variance, b.variance);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.albedo, b.albedo);
  EXPECT_EQ(a.id, b.id);
}

}  // namespace alidade::test
