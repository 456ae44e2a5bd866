// SPDX-License-Identifier: MIT
#include "renderer/disc_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "octree/distance.h"
#include "octree/spacing.h"

namespace alidade::renderer {
namespace {

constexpr double k_sheet_share = 0.25, k_sheet_slack = 0.004;
constexpr double k_falloff = 8.0;
// What a ray leaves behind: as far as its sheet reaches, and as thick as it is and curves.
constexpr double k_own_radii = 3.0, k_own_thicknesses = 3.0, k_own_rise = 0.1;

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
  query.filter = [rays, origins](const Candidate& candidate) {
    const SheetOrigin& origin = origins[candidate.query_index];
    if (candidate.disc == nullptr || origin.reach == 0.0f) return true;
    return std::fabs(glm::dot(candidate.disc->normal, origin.normal)) < k_same_sheet_cosine ||
           !is_part_of_surface(*candidate.disc, rays[candidate.query_index].origin, origin.reach,
                               origin.thickness);
  };
  return query;
}

void DiscCloud::blend(const Ray& ray, const std::vector<PointSphere>& around, DiscHit& hit) const {
  const TreeView& tree = octree_.view();
  const glm::dvec3 met = ray.origin + hit.t * ray.direction, first_normal = hit.sheet.normal;
  double sum = 0.0, t_sum = 0.0, farthest = 0.0;
  glm::dvec3 normal_sum(0.0), color_sum(0.0);
  for (const PointSphere& sphere : around) {
    const PointSurface surface = surface_at(tree, sphere.index);
    if (!surface.exists) continue;
    const PointDisc disc = point_disc(sphere.center, surface, sphere.radius);
    const double cosine = glm::dot(disc.normal, first_normal);
    const double height = std::fabs(glm::dot(met - disc.center, disc.normal));
    if (std::fabs(cosine) < k_same_sheet_cosine || height > k_sheet_share * disc.radius + k_sheet_slack)
      continue;
    const std::optional<double> t = plane_crossing(disc, ray.origin, ray.direction);
    // A ray along the sheet meets the planes anywhere.
    if (!t || std::fabs(*t - hit.t) > disc.radius) continue;
    const glm::dvec3 offset = met - disc.point;
    const double weight = std::exp(-k_falloff * glm::dot(offset, offset) / (disc.radius * disc.radius));
    sum += weight;
    t_sum += weight * (*t - hit.t);
    normal_sum += weight * (cosine < 0.0 ? -disc.normal : disc.normal);
    color_sum += weight * glm::dvec3(color_of(point_id(tree, sphere.index)));
    farthest = std::max(farthest, height);
  }
  if (!(sum > 0.0)) return;
  const double t = hit.t + t_sum / sum;
  if (t >= ray.t_min && t <= ray.t_max) hit.t = t;
  // A sheet that curves out of sight keeps the side that the ray came from.
  if (glm::dot(normal_sum, ray.direction) < 0.0) hit.sheet.normal = glm::normalize(normal_sum);
  hit.color = Color16(color_sum / sum + 0.5);
  hit.sheet.thickness += static_cast<float>(2.0 * farthest);
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
               .reach = static_cast<float>(k_own_radii * radius),
               .thickness = static_cast<float>(k_own_thicknesses * surface.thickness + k_own_rise * radius)};
  if (!blends) return hit;
  around.clear();
  find_enclosing(octree_, met, query_, around);
  blend(ray, around, hit);
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
