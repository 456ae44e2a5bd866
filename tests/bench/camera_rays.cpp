// SPDX-License-Identifier: MIT
#include "tests/bench/camera_rays.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <utility>

#include "simulation/noise.h"

namespace alidade::bench {

using namespace simulation;

std::vector<Ray> camera_rays(const glm::dvec3& eye, const glm::dvec3& target) {
  constexpr int k_width = 600, k_height = 400;
  constexpr double k_field_of_view = std::numbers::pi / 3.0;
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dvec3 down = glm::cross(forward, right);
  const double pixel = 2.0 * std::tan(0.5 * k_field_of_view) / k_height;
  std::vector<Ray> rays;
  rays.reserve(k_width * k_height);
  for (int y = 0; y < k_height; ++y) {
    for (int x = 0; x < k_width; ++x) {
      const double across = (x + 0.5 - 0.5 * k_width) * pixel, along = (y + 0.5 - 0.5 * k_height) * pixel;
      rays.push_back(make_ray(eye, forward + across * right + along * down, 0.0));
    }
  }
  return rays;
}

std::vector<BounceOrigin> bounce_origins(std::span<const Ray> rays,
                                         std::span<const std::optional<Hit>> hits) {
  std::vector<BounceOrigin> origins;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i]) continue;
    const glm::dvec3 position = rays[i].position(hits[i]->entry);
    origins.push_back({position, glm::normalize(position - hits[i]->position)});
  }
  return origins;
}

std::vector<Ray> bounce_rays(std::span<const BounceOrigin> origins, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Ray> rays;
  rays.reserve(origins.size());
  for (const BounceOrigin& origin : origins) {
    // A point of the unit sphere added to the normal is spread by the cosine.
    const double z = 2.0 * unit_of(random()) - 1.0, angle = 2.0 * std::numbers::pi * unit_of(random());
    const double ring = std::sqrt(1.0 - z * z);
    const glm::dvec3 spread(ring * std::cos(angle), ring * std::sin(angle), z);
    rays.push_back(make_ray(origin.position, 1.0001 * origin.normal + spread, 0.0));
  }
  return rays;
}

std::vector<Ray> parallel_rays(std::span<const BounceOrigin> origins, const glm::dvec3& direction) {
  std::vector<Ray> rays;
  for (const BounceOrigin& origin : origins) {
    if (glm::dot(origin.normal, direction) > 0.0) rays.push_back(make_ray(origin.position, direction, 0.0));
  }
  return rays;
}

std::vector<Ray> shuffled(std::vector<Ray> rays, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = rays.size(); i > 1; --i) std::swap(rays[i - 1], rays[random() % i]);
  return rays;
}

}  // namespace alidade::bench
