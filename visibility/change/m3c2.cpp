// SPDX-License-Identifier: MIT
#include "visibility/change/m3c2.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "octree/query.h"

namespace alidade::visibility {
namespace {

/// The hits within a window around t. Requires hits in order of t.
std::span<const Hit> around(std::span<const Hit> hits, double t, double window) {
  const auto begin = std::ranges::lower_bound(hits, t - window, {}, &Hit::t);
  const auto end = std::ranges::upper_bound(hits, t + window, {}, &Hit::t);
  return {begin, end};
}

double mean_of(std::span<const Hit> hits) {
  double sum = 0.0;
  for (const Hit& hit : hits) sum += hit.t;
  return sum / static_cast<double>(hits.size());
}

double deviation_of(std::span<const Hit> hits, double mean) {
  if (hits.size() < 2) return 0.0;
  double sum = 0.0;
  for (const Hit& hit : hits) sum += (hit.t - mean) * (hit.t - mean);
  return std::sqrt(sum / static_cast<double>(hits.size() - 1));
}

}  // namespace

std::optional<CylinderSurface> nearest_surface(const Octree& octree, const Cylinder& cylinder, double t,
                                               const CountedPoints& counts) {
  constexpr int k_most_steps = 8;
  RayQuery query{.radius = cylinder.radius, .measure = Measure::t};
  if (counts) query.filter = [&counts](const Candidate& point) { return counts(point.point_id); };
  const Ray axis{cylinder.center, cylinder.axis, -cylinder.half_length, cylinder.half_length};
  const std::vector<Hit> all = find(octree, axis, query);
  if (all.empty()) return std::nullopt;
  double mean = std::ranges::min_element(all, {}, [t](const Hit& hit) { return std::fabs(hit.t - t); })->t;
  std::span<const Hit> surface;
  for (int step = 0; step < k_most_steps; ++step) {
    const std::span<const Hit> next = around(all, mean, cylinder.window);
    // The mean of two halves may be far from all points.
    if (next.empty() || (next.data() == surface.data() && next.size() == surface.size())) break;
    surface = next;
    mean = mean_of(surface);
  }
  // Relative to the centre, since sums of map coordinates would lose digits.
  glm::dvec3 sum(0.0);
  for (const Hit& hit : surface) sum += hit.position - cylinder.center;
  return CylinderSurface{surface.size(), mean, deviation_of(surface, mean),
                         cylinder.center + sum / static_cast<double>(surface.size())};
}

double detection_level(const CylinderSurface& one, const CylinderSurface& other, double registration_error) {
  constexpr double k_confidence = 1.96;  // of a normal distribution, 95 % lie within so many deviations
  const auto variance = [](const CylinderSurface& surface) {
    return surface.deviation * surface.deviation / static_cast<double>(surface.count);
  };
  return k_confidence * (std::sqrt(variance(one) + variance(other)) + registration_error);
}

}  // namespace alidade::visibility
