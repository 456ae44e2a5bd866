// SPDX-License-Identifier: MIT
#include "renderer/disc_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "octree/spacing.h"

namespace alidade::renderer {
namespace {

constexpr double k_sheet_share = 0.25, k_sheet_slack = 0.004;
constexpr double k_falloff = 8.0;
// What a ray leaves behind: as far as its sheet reaches, and as thick as it is and curves.
constexpr double k_own_radii = 3.0, k_own_thicknesses = 3.0, k_own_rise = 0.1;

/// Rays that reach all points which these cross: up to a radius from where points are projected.
std::vector<Ray> widened(std::span<const Ray> rays, double radius) {
  std::vector<Ray> wider(rays.begin(), rays.end());
  for (Ray& ray : wider) {
    ray.t_min = -radius;
    ray.t_max += radius;
  }
  return wider;
}

}  // namespace

/// Where a ray meets the disc or sphere of one point.
struct DiscCloud::Crossing {
  double t = 0.0;
  std::uint64_t point_id = 0;
  PointDisc disc{};
  PointSurface surface{};
};

DiscCloud::DiscCloud(const LoadedCloud& cloud, bool blends)
    : cloud_(cloud), colors_(cloud.point_colors()), blends_(blends) {}

RayQuery DiscCloud::query() const {
  return {.radius = cloud_.radius, .spacing_factor = cloud_.spacing_factor};
}

std::optional<DiscCloud::Crossing> DiscCloud::crossing(const Ray& ray, const SheetOrigin& origin,
                                                       std::uint64_t point_id, const glm::dvec3& position,
                                                       double radius) const {
  const TreeView& tree = cloud_.octree.view();
  Crossing result{.point_id = point_id, .surface = surface_of(tree, point_id)};
  if (!result.surface.exists) {
    const double sphere =
        std::min({k_lone_spacings / cloud_.spacing_factor * radius, radius, cloud_.lone_radius});
    const glm::dvec3 offset = position - ray.origin;
    const double middle = glm::dot(offset, ray.direction);
    const glm::dvec3 beside = offset - middle * ray.direction;
    const double half_chord_sq = sphere * sphere - glm::dot(beside, beside);
    if (!(half_chord_sq >= 0.0)) return std::nullopt;
    result.t = middle - std::sqrt(half_chord_sq);
    // Rays that begin in it leave it.
    if (!(result.t > 0.0 && result.t < ray.t_max)) return std::nullopt;
    result.disc = {position, position, ray.direction, sphere};
    return result;
  }
  result.disc = point_disc(position, result.surface, radius);
  const std::optional<double> t = plane_crossing(result.disc, ray.origin, ray.direction);
  if (!t || !(*t > 0.0 && *t < ray.t_max)) return std::nullopt;
  result.t = *t;
  const glm::dvec3 met = ray.origin + *t * ray.direction;
  if (!is_within_radius(result.disc, met)) return std::nullopt;
  if (radius < cloud_.radius && is_beyond_edge(result.disc, met, tree, point_id, cloud_.spacing_factor))
    return std::nullopt;
  const bool is_own = origin.reach > 0.0 &&
                      is_part_of_surface(result.disc, ray.origin, origin.reach, origin.thickness) &&
                      std::fabs(glm::dot(result.disc.normal, origin.normal)) >= k_same_sheet_cosine;
  if (is_own) return std::nullopt;
  return result;
}

DiscHit DiscCloud::blended(const Ray& ray, const Crossing& first,
                           std::span<const Candidate> candidates) const {
  const auto color_of = [&](std::uint64_t id) { return colors_.empty() ? Color16(0) : colors_[id]; };
  DiscHit hit{.t = first.t, .point_id = first.point_id, .color = color_of(first.point_id)};
  const glm::dvec3 met = ray.origin + first.t * ray.direction;
  if (!first.surface.exists) {
    hit.sheet.normal = glm::normalize(met - first.disc.point);
    return hit;  // whose sphere no ray meets that begins on it
  }
  const auto facing = [&](const glm::dvec3& normal) {
    return glm::dot(normal, ray.direction) > 0.0 ? -normal : normal;
  };
  const glm::dvec3 first_normal = facing(first.disc.normal);
  hit.sheet = {.normal = first_normal,
               .reach = static_cast<float>(k_own_radii * first.disc.radius),
               .thickness = static_cast<float>(k_own_thicknesses * first.surface.thickness +
                                               k_own_rise * first.disc.radius)};
  if (!blends_) return hit;
  double sum = 0.0, t_sum = 0.0, farthest = 0.0;
  glm::dvec3 normal_sum(0.0), color_sum(0.0);
  for (const Candidate& candidate : candidates) {
    const PointSurface surface = surface_of(cloud_.octree.view(), candidate.point_id);
    if (!surface.exists) continue;
    const PointDisc disc = point_disc(candidate.position, surface, candidate.radius);
    if (!is_within_radius(disc, met)) continue;
    const double cosine = glm::dot(disc.normal, first_normal);
    const double height = std::fabs(glm::dot(met - disc.center, disc.normal));
    if (std::fabs(cosine) < k_same_sheet_cosine || height > k_sheet_share * disc.radius + k_sheet_slack)
      continue;
    const std::optional<double> t = plane_crossing(disc, ray.origin, ray.direction);
    // A ray along the sheet meets the planes anywhere.
    if (!t || std::fabs(*t - first.t) > disc.radius) continue;
    const glm::dvec3 offset = met - disc.point;
    const double weight = std::exp(-k_falloff * glm::dot(offset, offset) / (disc.radius * disc.radius));
    sum += weight;
    t_sum += weight * (*t - first.t);
    normal_sum += weight * (cosine < 0.0 ? -disc.normal : disc.normal);
    color_sum += weight * glm::dvec3(color_of(candidate.point_id));
    farthest = std::max(farthest, height);
  }
  if (!(sum > 0.0)) return hit;
  const double t = first.t + t_sum / sum;
  if (t > 0.0 && t < ray.t_max) hit.t = t;
  // A sheet that curves out of sight keeps the side that the ray came from.
  if (glm::dot(normal_sum, ray.direction) < 0.0) hit.sheet.normal = glm::normalize(normal_sum);
  hit.color = Color16(color_sum / sum + 0.5);
  hit.sheet.thickness += static_cast<float>(2.0 * farthest);
  return hit;
}

void DiscCloud::closest(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::optional<DiscHit>> hits) const {
  RayQuery first_query = query();
  const double widest = cloud_.radius;
  const auto crossing_of = [&](std::size_t ray, std::uint64_t id, const glm::dvec3& position, double radius) {
    return crossing(rays[ray], origins[ray], id, position, radius);
  };
  first_query.filter = [&](const Candidate& c) {
    return crossing_of(c.query_index, c.point_id, c.position, c.radius).has_value();
  };
  std::vector<std::optional<Hit>> entered(rays.size());
  alidade::closest(cloud_.octree, widened(rays, widest), first_query, entered);
  // Of the points whose spheres are entered no later than the first crossing found, one may be crossed earlier, and
  // some are blended.
  std::vector<Ray> around;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hits[i].reset();
    if (!entered[i]) continue;
    // To where the ray leaves that point's sphere, by when it has crossed its disc.
    const double leaves = 2.0 * entered[i]->t - entered[i]->entry;
    around.push_back({rays[i].origin, rays[i].direction, entered[i]->entry - widest, leaves + widest});
    numbers.push_back(i);
  }
  const std::vector<std::vector<Candidate>> found = candidates_along(around);
  for (std::size_t a = 0; a < around.size(); ++a) {
    const std::size_t i = numbers[a];
    std::optional<Crossing> first;
    for (const Candidate& near : found[a]) {
      const auto crossed = crossing_of(i, near.point_id, near.position, near.radius);
      if (!crossed) continue;
      if (!first || crossed->t < first->t || (crossed->t == first->t && crossed->point_id < first->point_id))
        first = crossed;
    }
    if (first) hits[i] = blended(rays[i], *first, found[a]);
  }
}

std::vector<std::vector<Candidate>> DiscCloud::candidates_along(std::span<const Ray> rays) const {
  constexpr std::size_t k_usual = 16;
  std::vector<std::vector<Candidate>> found(rays.size());
  RayQuery all = query();
  // A filter that rejects all is asked about every point, by lanes, which find() is not for radii of points' own.
  all.filter = [&](const Candidate& candidate) {
    std::vector<Candidate>& near = found[candidate.query_index];
    if (near.empty()) near.reserve(k_usual);
    near.push_back(candidate);
    return false;
  };
  std::vector<std::optional<Hit>> none(rays.size());
  alidade::closest(cloud_.octree, rays, all, none);
  for (std::vector<Candidate>& near : found) {
    // In an order of their own, each once, whatever the traversal did.
    std::ranges::sort(near, {}, &Candidate::point_id);
    const auto is_same = [](const Candidate& a, const Candidate& b) { return a.point_id == b.point_id; };
    near.erase(std::unique(near.begin(), near.end(), is_same), near.end());
  }
  return found;
}

void DiscCloud::blocked(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::uint8_t> answers) const {
  RayQuery asked_query = query();
  asked_query.filter = [&](const Candidate& c) {
    const std::size_t i = c.query_index;
    return crossing(rays[i], origins[i], c.point_id, c.position, c.radius).has_value();
  };
  occluded(cloud_.octree, widened(rays, cloud_.radius), asked_query, answers);
}

}  // namespace alidade::renderer
