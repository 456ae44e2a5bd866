// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/ray.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"

// Batches of rays that a tree answers in ways of its own.

namespace alidade::test {

inline PointCloud family_named(const std::string& name) {
  for (const PointFamily& family : point_families())
    if (family.name == name) return family.cloud;
  throw std::runtime_error("no family " + name);
}

/// Rays of nearly one direction: from one position (a camera), from anywhere, or from the points themselves
/// (to the sun), some of them with limits.
inline std::vector<Ray> alike_rays(const PointCloud& cloud, std::size_t count, Random& random) {
  std::vector<Ray> rays;
  const Bounds bounds = cloud.bounds();
  const double size = glm::length(bounds.size()) + 1e-3;
  const glm::dvec3 along = unit_direction(random.in_cube());
  const glm::dvec3 eye = bounds.center() - along * size * random.between(0.0, 2.0);
  const auto kind = random.below(3);
  const double spread = random.below(2) == 0 ? 0.0 : 0.01;
  for (std::size_t i = 0; i < count; ++i) {
    glm::dvec3 origin = eye;
    if (kind == 1) origin += 0.5 * size * random.in_cube();
    if (kind == 2) origin = cloud.world(static_cast<std::size_t>(random.below(cloud.size())));
    double t_min = kind == 0 ? -std::numeric_limits<double>::infinity() : 0.0;
    double t_max = std::numeric_limits<double>::infinity();
    if (random.below(4) == 0) t_min = size * random.between(-1.0, 1.0);
    if (random.below(4) == 0) t_max = size * random.between(-1.0, 3.0);
    // A few that do not go with the others, and some far away.
    const glm::dvec3 direction = random.below(50) == 0 ? random.in_cube() : along + spread * random.in_cube();
    if (random.below(60) == 0) origin -= 1e4 * size * along;
    rays.push_back(make_ray(origin, direction, t_min, t_max));
  }
  return rays;
}

/// From near the points of a site (family "far_zeros"), a few of them from the zeros and towards them.
inline std::vector<Ray> rays_at_site(const PointCloud& cloud, std::size_t count, bool are_alike,
                                     Random& random) {
  const auto site_point = [&] {
    return cloud.world(2 * static_cast<std::size_t>(random.below(cloud.size() / 2)));
  };
  const glm::dvec3 along = unit_direction(random.in_cube());
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const glm::dvec3 target = site_point();
    glm::dvec3 origin = site_point(), direction = target - origin;
    if (are_alike) {
      direction = along + 0.01 * random.in_cube();
      if (random.below(2) == 0) origin = target - std::pow(10.0, random.between(-2.0, 3.5)) * direction;
    }
    if (random.below(3) == 0) origin += 0.1 * random.in_cube();
    if (random.below(20) == 0) origin = glm::dvec3(0.0), direction = target;
    if (random.below(20) == 0) direction = -origin;
    if (random.below(30) == 0) direction = {0.0, random.below(2) ? 0.0 : -0.0, -1.0};
    if (direction == glm::dvec3(0.0)) continue;
    const double t_min =
        random.below(3) == 0 ? -std::numeric_limits<double>::infinity() : random.between(0.0, 0.1);
    rays.push_back(make_ray(origin, direction, t_min, random.below(3) == 0 ? 100.0 : 1e9));
  }
  return rays;
}

}  // namespace alidade::test
