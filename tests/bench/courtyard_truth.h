// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

#include "base/parallel.h"
#include "simulation/courtyard.h"
#include "simulation/scan.h"

// Scans of the courtyard, and what is seen of them past its exact surfaces.

namespace alidade {

inline const simulation::Site& courtyard_site() {
  static const simulation::Site site = simulation::courtyard();
  return site;
}

/// Five observers in the site's own frame: in the yard twice, at a window, above the roofs, in the arcade.
constexpr glm::dvec3 k_courtyard_eyes[] = {
    {5, -10, 1.7}, {23, -15.2, 6.8}, {9, -9, 1.7}, {45, -45, 40}, {-20, 2, 1.7}};

/// Positions and classes of a scan.
inline PointCloud courtyard_points(std::uint64_t count) {
  PointCloud cloud = simulation::scan_header(courtyard_site());
  simulation::scan(courtyard_site(), simulation::courtyard_scan(count, 1), [&](const PointCloud& batch) {
    cloud.positions.insert(cloud.positions.end(), batch.positions.begin(), batch.positions.end());
    cloud.classifications.insert(cloud.classifications.end(), batch.classifications.begin(),
                                 batch.classifications.end());
  });
  return cloud;
}

/// Per point, whether an eye sees the surface that it was measured on: the first surface in its direction is
/// not in front of it, or passes within the noise of the point.
inline std::vector<std::uint8_t> seen_in_truth(const PointCloud& cloud, const glm::dvec3& eye) {
  constexpr double k_noise = 0.02;  // metres across the surface
  std::vector<std::uint8_t> seen(cloud.size());
  in_parallel(cloud.size(), 1024, [&](std::size_t id) {
    const glm::dvec3 point = cloud.world(id), way = point - eye;
    const auto hit = courtyard_site().closest(make_ray(eye, way, 1e-6, glm::length(way)));
    seen[id] = !hit || std::fabs(glm::dot(point - hit->position, hit->normal)) < k_noise;
  });
  return seen;
}

}  // namespace alidade
