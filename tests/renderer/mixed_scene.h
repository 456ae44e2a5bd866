// SPDX-License-Identifier: MIT
#pragma once

#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

constexpr PointShape k_point_shapes[] = {PointShape::sphere, PointShape::disc, PointShape::blend};

inline std::string shape_name(PointShape shape) {
  return shape == PointShape::sphere ? "sphere" : shape == PointShape::disc ? "disc" : "blend";
}

/// A little of everything.
inline Scene mixed_scene(PointShape shape = PointShape::sphere) {
  Scene scene;
  scene.camera = pinhole_from_fov(70, 50, 50.0, look_at({0, -6, 3}, {0, 0, 0.5}));
  scene.render = {.samples = 5, .max_bounces = 6, .seed = 42};
  scene.sun.emplace();
  scene.cloud.emplace().shape = shape;
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.4f)}}, Sphere{{2, 0, 1}, 0.7, Dielectric{1.5}},
                   Sphere{{-2, 0, 1}, 0.7, Metal{Rgb(0.9f), 0.3}},
                   Sphere{{0, 1, 3}, 0.3, Emissive{Rgb(5.0f)}}};
  return scene;
}

/// Points anywhere for spheres; for discs a floor that ends at a wall, and points without a sheet in front of
/// them.
inline std::vector<glm::dvec3> mixed_points(PointShape shape) {
  Random random("mixed cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) {
    glm::dvec3 position = random.in_cube();
    if (shape != PointShape::sphere && i % 32 != 0) {
      const int across = i % 2 == 0 ? 1 : 2;
      position[across] = (across == 1 ? 0.9 : -0.8) + 0.003 * position[across];
    }
    positions.push_back(position + glm::dvec3(0, 0, 1));
  }
  return positions;
}

inline LoadedCloud mixed_cloud(PointShape shape = PointShape::sphere,
                               InstructionSet instruction_set = InstructionSet::best) {
  LoadedCloud cloud = loaded(mixed_points(shape), 0.06, k_millimetres, instruction_set);
  if (shape == PointShape::sphere) return cloud;
  Random random("mixed colors");
  for (Color16& color : cloud.colors)
    for (int channel = 0; channel < 3; ++channel)
      color[channel] = static_cast<std::uint16_t>(random.below(65536));
  choose_radius(*mixed_scene(shape).cloud, cloud);
  return cloud;
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
  EXPECT_EQ(a.depth_sigma, b.depth_sigma);
  EXPECT_EQ(a.coverage, b.coverage);
  EXPECT_EQ(a.support, b.support);
}

}  // namespace alidade::test
