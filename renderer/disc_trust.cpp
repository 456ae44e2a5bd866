// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

#include "octree/distance.h"
#include "octree/local_plane.h"
#include "renderer/disc_tracer.h"

namespace alidade::renderer {
namespace {

// Chosen so that fewer than 1 % of the depths of the sample site, at 1e5 to 5e6 points, are wrong by more
// than 3 standard deviations (docs/reports/fidelity.md).
constexpr double k_shift = 1.0;   ///< spacings by which sheets may reach farther than their edges
constexpr double k_wider = 2.5;   ///< times the radius that discs may have,
constexpr double k_larger = 4.0;  ///< and spheres
constexpr double k_amid = 1.1;    ///< spacings within which points of a sheet surround what is not at its rim
constexpr double k_apart = 1.2;   ///< standard deviations to what could be met instead
constexpr int k_most_rims = 32;   ///< one behind another

/// The widest angle at a point of a plane in which no other point lies, in radians. offsets: of the others.
double widest_gap(const glm::dvec3& normal, std::span<const glm::dvec3> offsets) {
  const PlaneAxes axes = axes_across(normal);
  constexpr double k_turn = 2.0 * glm::pi<double>();
  if (offsets.empty()) return k_turn;
  std::vector<double> angles;
  for (const glm::dvec3& offset : offsets)
    angles.push_back(std::atan2(glm::dot(offset, axes.second), glm::dot(offset, axes.first)));
  std::ranges::sort(angles);
  double gap = k_turn - (angles.back() - angles.front());
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) gap = std::max(gap, angles[i + 1] - angles[i]);
  return gap;
}

}  // namespace

/// A hit at the rim of a sheet, or on a sphere.
struct DiscCloud::Rim {
  std::size_t number;  ///< of the ray
  double t;
  SheetOrigin sheet;
  double passed;  ///< of the way behind that still belongs to it, metres
};

std::optional<DiscCloud::Rim> DiscCloud::rim(const Ray& ray, std::size_t number, const Hit& first,
                                             double before, std::vector<PointSphere>& around) const {
  const double chord = project(ray, first.position).t - first.t;
  if (!surface_of(octree_.view(), first.point_id).exists)
    return Rim{number, before + first.t, {}, 2.0 * chord};
  const DiscHit hit = disc_hit(ray, first, false, around);
  const glm::dvec3 met = ray.origin + first.t * ray.direction, normal = hit.sheet.normal;
  RayQuery reached = query_;
  reached.spacing_factor = k_amid;
  around.clear();
  find_enclosing(octree_, met, reached, around);
  std::vector<glm::dvec3> offsets;
  for (const PointSphere& sphere : around) {
    const PointSurface surface = surface_at(octree_.view(), sphere.index);
    if (surface.exists && is_of_sheet(point_disc(sphere.center, surface, sphere.radius), met, normal))
      offsets.push_back(sphere.center - met);
  }
  if (widest_gap(normal, offsets) < glm::pi<double>()) return std::nullopt;
  return Rim{number, before + first.t, hit.sheet, 0.0};
}

HitTrust DiscCloud::trust_amid(const Ray& ray, const Hit& first, std::vector<PointSphere>& around) const {
  constexpr double k_least_share = 0.01;  // of the radius
  const PointSurface surface = surface_of(octree_.view(), first.point_id);
  if (!surface.exists) return {project(ray, first.position).t - first.t, 1};
  const DiscHit hit = disc_hit(ray, first, false, around);
  const SheetSums sums = blend(ray, hit, around);
  const double slope = std::fabs(glm::dot(hit.sheet.normal, ray.direction));
  const double thickness = (surface.thickness + k_least_share * hit.sheet.reach / k_sheet_radii) / slope;
  const std::uint32_t support = std::max(sums.count, 1u);
  return {std::sqrt(sums.spread() + thickness * thickness / support), support};
}

void DiscCloud::trust(std::span<const Ray> rays, std::span<HitTrust> answers) const {
  RayQuery wide = query_;
  wide.edge_shift += k_shift;
  wide.lone_factor *= k_larger;
  wide.spacing_factor *= k_wider;
  std::vector<std::optional<Hit>> first(rays.size()), earlier(rays.size());
  alidade::closest(octree_, rays, query_, first);
  alidade::closest(octree_, rays, wide, earlier);
  std::vector<PointSphere> around;
  std::vector<Rim> rims;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    answers[i] = {};
    if (!first[i]) continue;
    answers[i] = trust_amid(rays[i], *first[i], around);
    if (earlier[i]) answers[i].sigma = std::max(answers[i].sigma, (first[i]->t - earlier[i]->t) / k_apart);
    if (const auto found = rim(rays[i], i, *first[i], 0.0, around)) rims.push_back(*found);
  }
  // At a rim the surface may be what lies behind; in foliage that is another rim.
  for (int round = 0; round < k_most_rims && !rims.empty(); ++round) {
    std::vector<Ray> on;
    std::vector<SheetOrigin> sheets;
    for (const Rim& at : rims) {
      const Ray& ray = rays[at.number];
      on.push_back({ray.origin + at.t * ray.direction, ray.direction, at.passed, ray.t_max - at.t});
      sheets.push_back(at.sheet);
    }
    std::vector<std::optional<Hit>> behind(on.size());
    alidade::closest(octree_, on, query_of(on, sheets), behind);
    std::vector<Rim> next;
    for (std::size_t i = 0; i < rims.size(); ++i) {
      const std::size_t number = rims[i].number;
      double& sigma = answers[number].sigma;
      if (!behind[i]) {
        sigma = std::numeric_limits<double>::infinity();
        continue;
      }
      sigma = std::max(sigma, (rims[i].t + behind[i]->t - first[number]->t) / k_apart);
      if (const auto found = rim(on[i], number, *behind[i], rims[i].t, around)) next.push_back(*found);
    }
    rims = std::move(next);
  }
}

}  // namespace alidade::renderer
