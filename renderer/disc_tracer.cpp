// SPDX-License-Identifier: MIT
#include "renderer/disc_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

#include "octree/distance.h"
#include "octree/spacing.h"
#include "surface/local_plane.h"
#include "surface/point_disc.h"

namespace alidade::renderer {
namespace {

constexpr double k_falloff = 8.0;
// What a ray leaves behind: as far as its sheet reaches, and as thick as it is and curves.
constexpr double k_own_thicknesses = 3.0, k_own_rise = 0.1;

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

/// How far a sheet reaches around a hit, in radii of the disc.
constexpr double k_sheet_radii = 3.0;

double height_above_sheet(const PointDisc& disc, const glm::dvec3& position) {
  return std::fabs(glm::dot(position - disc.center, disc.normal));
}

/// Whether a disc is of the sheet that has this normal where a ray meets it.
bool is_of_sheet(const PointDisc& disc, const glm::dvec3& met, const glm::dvec3& normal) {
  constexpr double k_share = 0.25, k_slack = 0.004;  // of the radius; metres
  return std::fabs(glm::dot(disc.normal, normal)) >= k_same_sheet_cosine &&
         height_above_sheet(disc, met) <= k_share * disc.radius + k_slack;
}

}  // namespace

/// A disc that may share in a blended surface.
struct DiscCloud::Neighbour {
  PointDisc disc;
  glm::dvec3 color{0.0};  ///< display value
};

/// Those around a position; kept as room for the next ones.
struct DiscCloud::Neighbours {
  std::vector<PointSphere> spheres;
  std::vector<Neighbour> discs;
};

/// A hit that is to be blended.
struct DiscCloud::Blended {
  std::uint32_t index;   ///< storage index of the point
  std::uint32_t number;  ///< of the ray

  auto operator<=>(const Blended&) const = default;
};

/// Weighted sums over the discs of a sheet.
struct DiscCloud::SheetSums {
  std::uint32_t count = 0;
  double weight = 0.0, t = 0.0, t_squared = 0.0;  ///< t from that of the first crossing, metres
  glm::dvec3 normal{0.0}, color{0.0};
  double farthest = 0.0;  ///< plane from the first crossing, metres
  double greatest_weight = 0.0;
  glm::dvec3 nearest_color{0.0};  ///< of the disc that has it

  /// Variance of t.
  double spread() const {
    if (!(weight > 0.0)) return 0.0;
    const double mean = t / weight;
    return std::fmax(t_squared / weight - mean * mean, 0.0);
  }
};

DiscCloud::DiscCloud(const LoadedCloud& cloud, bool blends)
    : surfaces_(cloud.surfaces),
      query_{.radius = cloud.radius,
             .spacing_factor = cloud.spacing_factor,
             .discs = DiscQuery{.lone_radius = cloud.lone_radius}},
      colors_(cloud.point_colors()),
      blends_(blends),
      are_categories_(!cloud.color.swatches.empty()) {}

SurfaceQuery DiscCloud::query_of(std::span<const SheetOrigin> origins) const {
  SurfaceQuery query = query_;
  const bool all_in_air =
      std::ranges::all_of(origins, [](const SheetOrigin& origin) { return origin.reach == 0.0f; });
  if (!all_in_air) query.discs->begins = origins;
  return query;
}

void DiscCloud::find_neighbours(const glm::dvec3& position, double reach, Neighbours& around) const {
  around.spheres.clear();
  around.discs.clear();
  find_spheres(surfaces_, position, reach, query_, around.spheres);
  for (const PointSphere& sphere : around.spheres) {
    const PointSurface surface = surfaces_.surface_at(sphere.index);
    if (!surface.exists) continue;
    around.discs.push_back({point_disc(sphere.center, surface, sphere.radius),
                            glm::dvec3(color_of(colors_, point_id(surfaces_.view().tree, sphere.index)))});
  }
}

DiscCloud::SheetSums DiscCloud::sums(const Ray& ray, const DiscHit& hit,
                                     std::span<const Neighbour> around) const {
  const glm::dvec3 met = ray.position(hit.t), first_normal = hit.sheet.normal;
  SheetSums sums;
  for (const auto& [disc, color] : around) {
    if (!(distance(met, disc.point) <= disc.radius) || !is_of_sheet(disc, met, first_normal)) continue;
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
    sums.color += weight * color;
    if (weight > sums.greatest_weight) {
      sums.greatest_weight = weight;
      sums.nearest_color = color;
    }
    sums.farthest = std::max(sums.farthest, height_above_sheet(disc, met));
  }
  return sums;
}

DiscHit DiscCloud::disc_hit(const Ray& ray, const SurfaceHit& first) const {
  DiscHit hit{.t = first.t, .point_id = first.point_id, .color = color_of(colors_, first.point_id)};
  const PointSurface surface = surfaces_.surface_at(first.index);
  const glm::dvec3 met = ray.origin + first.t * ray.direction;
  if (!surface.exists) {
    hit.sheet.normal = glm::normalize(met - first.position);
    return hit;  // whose sphere no ray meets that begins on it
  }
  const double radius = own_radius(query_, spacing_at(surfaces_.view().layers, first.index));
  const PointDisc disc = point_disc(first.position, surface, radius);
  hit.sheet = {.normal = glm::dot(disc.normal, ray.direction) > 0.0 ? -disc.normal : disc.normal,
               .reach = static_cast<float>(k_sheet_radii * radius),
               .thickness = static_cast<float>(k_own_thicknesses * surface.thickness + k_own_rise * radius)};
  return hit;
}

void DiscCloud::blend(std::span<const Ray> rays, std::span<const Blended> blended,
                      std::span<std::optional<DiscHit>> hits, Neighbours& room) const {
  const auto met = [&](const Blended& hit) { return rays[hit.number].position(hits[hit.number]->t); };
  Bounds bounds;
  for (const Blended& hit : blended) bounds.grow(met(hit));
  const glm::dvec3 middle = blended.size() == 1 ? bounds.min : bounds.center();
  double reach = 0.0;
  for (const Blended& hit : blended) reach = std::max(reach, distance(middle, met(hit)));
  // Distances are rounded; a sphere that holds a hit must still be found.
  if (reach > 0.0) reach += 0x1p-40 * (reach + query_.radius);
  find_neighbours(middle, reach, room);
  // Beside a denser part of the cloud much more can be near all of the hits than holds any of them.
  constexpr std::size_t k_most_shared = 64;
  if (blended.size() > 1 && room.discs.size() > k_most_shared) {
    for (std::size_t i = 0; i < blended.size(); ++i) blend(rays, blended.subspan(i, 1), hits, room);
    return;
  }
  for (const Blended& each : blended) {
    const Ray& ray = rays[each.number];
    DiscHit& hit = *hits[each.number];
    const SheetSums sheet = sums(ray, hit, room.discs);
    if (!(sheet.weight > 0.0)) continue;
    const double t = hit.t + sheet.t / sheet.weight;
    if (t >= ray.t_min && t <= ray.t_max) hit.t = t;
    // A sheet that curves out of sight keeps the side that the ray came from.
    if (glm::dot(sheet.normal, ray.direction) < 0.0) hit.sheet.normal = glm::normalize(sheet.normal);
    hit.color = are_categories_ ? Color16(sheet.nearest_color) : Color16(sheet.color / sheet.weight + 0.5);
    hit.sheet.thickness += static_cast<float>(2.0 * sheet.farthest);
  }
}

void DiscCloud::closest(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::optional<DiscHit>> hits) const {
  std::vector<std::optional<SurfaceHit>> first(rays.size());
  alidade::closest(surfaces_, rays, query_of(origins), first);
  const ColorsAhead colors(colors_, first);
  std::vector<Blended> blended;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    colors.fetch(i);
    hits[i].reset();
    if (!first[i]) continue;
    hits[i] = disc_hit(rays[i], *first[i]);
    if (blends_ && origins[i].reach == 0.0f && hits[i]->sheet.reach > 0.0f)
      blended.push_back({first[i]->index, static_cast<std::uint32_t>(i)});
  }
  // Hits on one disc share its neighbours.
  std::ranges::sort(blended);
  Neighbours room;
  for (std::span<const Blended> rest = blended; !rest.empty();) {
    const auto others =
        std::ranges::find_if(rest, [&](const Blended& hit) { return hit.index != rest.front().index; });
    const auto count = static_cast<std::size_t>(others - rest.begin());
    blend(rays, rest.first(count), hits, room);
    rest = rest.subspan(count);
  }
}

void DiscCloud::blocked(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
                        std::span<std::uint8_t> answers) const {
  occluded(surfaces_, rays, query_of(origins), answers);
}

/// A hit at the rim of a sheet, or on a sphere.
struct DiscCloud::Rim {
  std::size_t number;  ///< of the ray
  double t;
  SheetOrigin sheet;
  double passed;  ///< of the way behind that still belongs to it, metres
};

std::optional<DiscCloud::Rim> DiscCloud::rim(const Ray& ray, std::size_t number, const SurfaceHit& first,
                                             double before) const {
  const double chord = project(ray, first.position).t - first.t;
  if (!surfaces_.surface_at(first.index).exists) return Rim{number, before + first.t, {}, 2.0 * chord};
  const DiscHit hit = disc_hit(ray, first);
  const glm::dvec3 met = ray.origin + first.t * ray.direction, normal = hit.sheet.normal;
  SurfaceQuery reached = query_;
  reached.spacing_factor = k_amid;
  std::vector<PointSphere> around;
  find_spheres(surfaces_, met, 0.0, reached, around);
  std::vector<glm::dvec3> offsets;
  for (const PointSphere& sphere : around) {
    const PointSurface surface = surfaces_.surface_at(sphere.index);
    if (surface.exists && is_of_sheet(point_disc(sphere.center, surface, sphere.radius), met, normal))
      offsets.push_back(sphere.center - met);
  }
  if (widest_gap(normal, offsets) < glm::pi<double>()) return std::nullopt;
  return Rim{number, before + first.t, hit.sheet, 0.0};
}

HitTrust DiscCloud::trust_amid(const Ray& ray, const SurfaceHit& first, Neighbours& room) const {
  constexpr double k_least_share = 0.01;  // of the radius
  const PointSurface surface = surfaces_.surface_at(first.index);
  if (!surface.exists) return {project(ray, first.position).t - first.t, 1};
  const DiscHit hit = disc_hit(ray, first);
  find_neighbours(ray.position(hit.t), 0.0, room);
  const SheetSums sheet = sums(ray, hit, room.discs);
  const double slope = std::fabs(glm::dot(hit.sheet.normal, ray.direction));
  const double thickness = (surface.thickness + k_least_share * hit.sheet.reach / k_sheet_radii) / slope;
  const std::uint32_t support = std::max(sheet.count, 1u);
  return {std::sqrt(sheet.spread() + thickness * thickness / support), support};
}

void DiscCloud::trust(std::span<const Ray> rays, std::span<HitTrust> answers) const {
  SurfaceQuery wide = query_;
  wide.discs->edge_shift += k_shift;
  wide.discs->lone_factor *= k_larger;
  wide.spacing_factor *= k_wider;
  std::vector<std::optional<SurfaceHit>> first(rays.size()), earlier(rays.size());
  alidade::closest(surfaces_, rays, query_, first);
  alidade::closest(surfaces_, rays, wide, earlier);
  std::vector<Rim> rims;
  Neighbours room;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    answers[i] = {};
    if (!first[i]) continue;
    answers[i] = trust_amid(rays[i], *first[i], room);
    if (earlier[i]) answers[i].sigma = std::max(answers[i].sigma, (first[i]->t - earlier[i]->t) / k_apart);
    if (const auto found = rim(rays[i], i, *first[i], 0.0)) rims.push_back(*found);
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
    std::vector<std::optional<SurfaceHit>> behind(on.size());
    alidade::closest(surfaces_, on, query_of(sheets), behind);
    std::vector<Rim> next;
    for (std::size_t i = 0; i < rims.size(); ++i) {
      const std::size_t number = rims[i].number;
      double& sigma = answers[number].sigma;
      if (!behind[i]) {
        sigma = std::numeric_limits<double>::infinity();
        continue;
      }
      sigma = std::max(sigma, (rims[i].t + behind[i]->t - first[number]->t) / k_apart);
      if (const auto found = rim(on[i], number, *behind[i], rims[i].t)) next.push_back(*found);
    }
    rims = std::move(next);
  }
}

}  // namespace alidade::renderer
