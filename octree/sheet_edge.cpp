// SPDX-License-Identifier: MIT
#include "octree/sheet_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "octree/query.h"

namespace alidade {
namespace {

// 8 bits: 3 for the distance, of which 0 stands for none, and 5 for the direction.
constexpr int k_directions = 32, k_levels = 7;
// In spacings.
constexpr double k_step = 0.1, k_gap = 0.2, k_reach = 2.5, k_least_support = 1.5;
/// What lies within this of a line in some direction tells how far the sheet reaches there: some nine points
/// between the edge and the reach.
constexpr double k_half_width = 1.2;

struct Axes {
  glm::dvec3 first, second;
};

/// Two directions in the plane across a normal, of length 1 and at right angles.
Axes axes_across(const glm::dvec3& normal) {
  const glm::dvec3 across =
      std::fabs(normal.z) < 0.7 ? glm::dvec3(normal.y, -normal.x, 0.0) : glm::dvec3(0.0, normal.z, -normal.y);
  const glm::dvec3 first = glm::normalize(across);
  return {first, glm::cross(normal, first)};
}

/// All around in even steps. Made with roots alone, which are the same on every machine.
const std::array<glm::dvec2, k_directions>& directions() {
  static const std::array<glm::dvec2, k_directions> all = [] {
    std::array<glm::dvec2, k_directions> made{};
    made[0] = {1.0, 0.0};
    made[k_directions / 4] = {0.0, 1.0};
    for (int step = k_directions / 4; step > 1; step /= 2) {
      for (int i = 0; i < k_directions / 4; i += step)
        made[i + step / 2] = glm::normalize(made[i] + made[i + step]);
    }
    for (int i = k_directions / 4; i < k_directions; ++i) {
      const glm::dvec2& before = made[i - k_directions / 4];
      made[i] = {-before.y, before.x};
    }
    return made;
  }();
  return all;
}

/// How far the sheet's points around a point reach in each direction, in spacings; 0 if there are none.
std::array<double, k_directions> reaches(const Octree& octree, const glm::dvec3& position, double spacing,
                                         const PointSurface& surface) {
  constexpr double k_thicknesses = 4.0, k_spacings = 1e-3;
  const double thickness = k_thicknesses * surface.thickness + k_spacings * spacing;
  const Axes axes = axes_across(surface.normal);
  std::array<double, k_directions> farthest{};
  for (const PointHit& point : find(octree, position, PointQuery{.radius = k_reach * spacing})) {
    const glm::dvec3 offset = point.position - position;
    if (std::fabs(glm::dot(offset, surface.normal) + surface.height) > thickness) continue;
    const glm::dvec2 place(glm::dot(offset, axes.first) / spacing, glm::dot(offset, axes.second) / spacing);
    for (int i = 0; i < k_directions; ++i) {
      const glm::dvec2& direction = directions()[i];
      const double beside = std::fabs(place.x * direction.y - place.y * direction.x);
      const double along = place.x * direction.x + place.y * direction.y;
      farthest[i] = beside < k_half_width ? std::max(farthest[i], along) : farthest[i];
    }
  }
  return farthest;
}

}  // namespace

std::uint8_t fit_sheet_edge(const Octree& octree, const glm::dvec3& position, double spacing,
                            const PointSurface& surface) {
  if (!surface.exists) return 0;
  const std::array<double, k_directions> farthest = reaches(octree, position, spacing, surface);
  int best = -1;
  for (int i = 0; i < k_directions; ++i) {
    const bool has_support = farthest[(i + k_directions / 2) % k_directions] >= k_least_support;
    if (has_support && (best < 0 || farthest[i] < farthest[best])) best = i;
  }
  if (best < 0) return 0;
  const int level = static_cast<int>(std::lround(farthest[best] / k_step)) + 1;
  return level > k_levels ? 0 : static_cast<std::uint8_t>(k_directions * level + best);
}

SheetEdge edge_of(const TreeView& tree, std::uint64_t point_id, const glm::dvec3& normal) {
  const int packed = tree.sheet_edges[point_id], level = packed / k_directions;
  if (level == 0) return {};
  const Axes axes = axes_across(normal);
  const glm::dvec2& direction = directions()[packed % k_directions];
  return {direction.x * axes.first + direction.y * axes.second, k_gap + k_step * (level - 1)};
}

}  // namespace alidade
