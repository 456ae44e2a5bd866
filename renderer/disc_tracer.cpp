// SPDX-License-Identifier: MIT
#include "renderer/disc_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "octree/distance.h"
#include "octree/spacing.h"

namespace alidade::renderer {
namespace {

constexpr double k_falloff = 8.0;
// What a ray leaves behind: as far as its sheet reaches, and as thick as it is and curves.
constexpr double k_own_thicknesses = 3.0, k_own_rise = 0.1;

}  // namespace

DiscCloud::DiscCloud(const LoadedCloud& cloud, bool blends)
    : octree_(with_discs(cloud.octree)),
      query_{.radius = cloud.radius,
             .measure = Measure::crossing,
             .spacing_factor = cloud.spacing_factor,
             .lone_radius = cloud.lone_radius},
      colors_(cloud.point_colors()),
      blends_(blends) {}

RayQuery DiscCloud::query_of(std::span<const Ray> rays, std::span<const SheetOrigin> origins) const {
  RayQuery query = query_;
  if (std::ranges::all_of(origins, [](const SheetOrigin& origin) { return origin.reach == 0.0f; }))
    return query;
  query.position_filter = [rays, origins](const Candidate& candidate) {
    const SheetOrigin& origin = origins[candidate.query_index];
    if (candidate.disc == nullptr || origin.reach == 0.0f) return true;
    return std::fabs(glm::dot(candidate.disc->normal, origin.normal)) < k_same_sheet_cosine ||
           !is_part_of_surface(*candidate.disc, rays[candidate.query_index].origin, origin.reach,
                               origin.thickness);
  };
  return query;
}

SheetSums DiscCloud::blend(const Ray& ray, const DiscHit& hit, std::vector<PointSphere>& around) const {
  const TreeView& tree = octree_.view();
  const glm::dvec3 met = ray.origin + hit.t * ray.direction, first_normal = hit.sheet.normal;
  around.clear();
  find_enclosing(octree_, met, query_, around);
  SheetSums sums;
  for (const PointSphere& sphere : around) {
    const PointSurface surface = surface_at(tree, sphere.index);
    if (!surface.exists) continue;
    const PointDisc disc = point_disc(sphere.center, surface, sphere.radius);
    if (!is_of_sheet(disc, met, first_normal)) continue;
    const std::optional<double> t = plane_crossing(disc, ray.origin, ray.direction);
    // A ray along the sheet meets the planes anywhere.
    if (!t || std::fabs(*t - hit.t) > disc.radius) continue;
    const glm::dvec3 offset = met - disc.point;
    const double weight = std::exp(-k_falloff * glm::dot(offset, offset) / (disc.radius * disc.radius));
    const double later = *t - hit.t;
    ++sums.count;
    sums.weight += weight;
    sums.t += weight * later;
    sums.t_squared += weight * later * later;
    sums.normal += weight * (glm::dot(disc.normal, first_normal) < 0.0 ? -disc.normal : disc.normal);
    sums.color += weight * glm::dvec3(color_of(point_id(tree, sphere.index)));
    sums.farthest = std::max(sums.farthest, height_above_sheet(disc, met));
  }
  return sums;
}

DiscHit DiscCloud::disc_hit(const Ray& ray, const Hit& first, bool blends,
                            std::vector<PointSphere>& around) const {
  DiscHit hit{.t = first.t, .point_id = first.point_id, .color = color_of(first.point_id)};
  const PointSurface surface = surface_of(octree_.view(), first.point_id);
  const glm::dvec3 met = ray.origin + first.t * ray.direction;
  if (!surface.exists) {
    hit.sheet.normal = glm::normalize(met - first.position);
    return hit;  // whose sphere no ray meets that begins on it
  }
  Hit on_sphere = first;
  on_sphere.t = project(ray, first.position).t;
  const double radius = sphere_radius(query_, on_sphere);
  const PointDisc disc = point_disc(first.position, surface, radius);
  hit.sheet = {.normal = glm::dot(disc.normal, ray.direction) > 0.0 ? -disc.normal : disc.normal,
               .reach = static_cast<float>(k_sheet_radii * radius),
               .thickness = static_cast<float>(k_own_thicknesses * surface.thickness + k_own_rise * radius)};
  if (!blends) return hit;
  const SheetSums sums = blend(ray, hit, around);
  if (!(sums.weight > 0.0)) return hit;
  const double t = hit.t + sums.t / sums.weight;
  if (t >= ray.t_min && t <= ray.t_max) hit.t = t;
  // A sheet that curves out of sight keeps the side that the ray came from.
  if (glm::dot(sums.normal, ray.direction) < 0.0) hit.sheet.normal = glm::normalize(sums.normal);
  hit.color = Color16(sums.color / sums.weight + 0.5);
  hit.sheet.thickness += static_cast<float>(2.0 * sums.farthest);
  return hit;
}

void DiscCloud::closest(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::optional<DiscHit>> hits) const {
  std::vector<std::optional<Hit>> first(rays.size());
  alidade::closest(octree_, rays, query_of(rays, origins), first);
  std::vector<PointSphere> around;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hits[i].reset();
    if (first[i]) hits[i] = disc_hit(rays[i], *first[i], blends_ && origins[i].reach == 0.0f, around);
  }
}

void DiscCloud::blocked(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::uint8_t> answers) const {
  occluded(octree_, rays, query_of(rays, origins), answers);
}

}  // namespace alidade::renderer
