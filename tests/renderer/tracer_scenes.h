// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "camera/camera.h"
#include "octree/build.h"
#include "renderer/render.h"
#include "tests/support/point_families.h"

// Small scenes and the comparison with answers known on paper.

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

inline Camera camera_at(const glm::dvec3& eye, const glm::dvec3& target, double vertical_fov, int size = 16) {
  const glm::dvec3 view = target - eye;
  const bool vertical = view.x == 0.0 && view.y == 0.0;
  return pinhole_from_fov(size, size, vertical_fov,
                          look_at(eye, target, vertical ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1)));
}

inline Scene dark_scene(const Camera& camera, int samples, int max_bounces) {
  Scene scene;
  scene.sky = ConstantSky{};
  scene.camera = camera;
  scene.render.samples = samples;
  scene.render.max_bounces = max_bounces;
  return scene;
}

inline const Lattice k_millimetres{glm::dvec3(0.001), glm::dvec3(0.0)};

/// A cloud of white points, ready to trace.
inline LoadedCloud loaded(const std::vector<glm::dvec3>& positions, double radius,
                          const Lattice& lattice = k_millimetres,
                          InstructionSet instruction_set = InstructionSet::best) {
  BuildOptions options;
  options.instruction_set = instruction_set;
  LoadedCloud cloud;
  cloud.octree = build(make_cloud(positions, lattice), options);
  cloud.colors.assign(positions.size(), Color16(65535));
  cloud.radius = radius;
  return cloud;
}

/// Mean of the whole image and its standard error, first channel.
struct ImageMean {
  double mean = 0.0, standard_error = 0.0;
};

inline ImageMean image_mean(const Film& film) {
  ImageMean result;
  double variance = 0.0;
  for (std::size_t pixel = 0; pixel < film.color.size(); ++pixel) {
    result.mean += film.color[pixel].r;
    variance += film.variance[pixel].r;
  }
  const auto count = static_cast<double>(film.color.size());
  result.mean /= count;
  result.standard_error = std::sqrt(variance) / count;
  return result;
}

/// The image's mean is the answer: within 0.5 % and within five standard errors (which the scrambled sequence
/// undercuts).
inline void expect_mean(const Film& film, double answer) {
  const ImageMean found = image_mean(film);
  EXPECT_NEAR(found.mean, answer, 0.005 * answer);
  EXPECT_NEAR(found.mean, answer, 5.0 * found.standard_error + 1e-6 * answer);
}

/// Every pixel is the answer, but for float rounding: for scenes whose estimate has no variance.
inline void expect_everywhere(const Film& film, double answer, double relative = 1e-5) {
  for (const Rgb& color : film.color) {
    for (int channel = 0; channel < 3; ++channel) ASSERT_NEAR(color[channel], answer, relative * answer);
  }
}

}  // namespace alidade::test
