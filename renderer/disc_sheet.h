// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "octree/point_disc.h"

// The sheet that a ray meets: which discs around belong to it, and what they add up to.

namespace alidade::renderer {

/// Cosine of the 32 degrees by which normals of one sheet deviate at most.
constexpr double k_same_sheet_cosine = 0.848;

/// How far a sheet reaches around a hit, in radii of the disc.
constexpr double k_sheet_radii = 3.0;

inline double height_above_sheet(const PointDisc& disc, const glm::dvec3& position) {
  return std::fabs(glm::dot(position - disc.center, disc.normal));
}

/// Whether a disc is of the sheet that has this normal where a ray meets it.
inline bool is_of_sheet(const PointDisc& disc, const glm::dvec3& met, const glm::dvec3& normal) {
  constexpr double k_share = 0.25, k_slack = 0.004;  // of the radius; metres
  return std::fabs(glm::dot(disc.normal, normal)) >= k_same_sheet_cosine &&
         height_above_sheet(disc, met) <= k_share * disc.radius + k_slack;
}

/// Weighted sums over the discs of a sheet.
struct SheetSums {
  std::uint32_t count = 0;
  double weight = 0.0, t = 0.0, t_squared = 0.0;  ///< t from that of the first crossing, metres
  glm::dvec3 normal{0.0}, color{0.0};
  double farthest = 0.0;  ///< plane from the first crossing, metres

  /// Variance of t.
  double spread() const {
    if (!(weight > 0.0)) return 0.0;
    const double mean = t / weight;
    return std::fmax(t_squared / weight - mean * mean, 0.0);
  }
};

}  // namespace alidade::renderer
