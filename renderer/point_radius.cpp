// SPDX-License-Identifier: MIT
#include "renderer/load_cloud.h"

#include <cmath>
#include <string>

#include "octree/query.h"
#include "octree/spacing.h"

namespace alidade {
namespace {

/// Lone points far from all others would become balloons: no sphere is larger than so many times the radius
/// that closes nearly all surfaces.
constexpr double k_widest_over_automatic = 4.0;

double positive(double value, const char* what) {
  if (value > 0.0 && std::isfinite(value)) return value;
  throw Error({.problem = std::string("bad ") + what,
               .expected = "a positive number",
               .found = std::to_string(value)});
}

}  // namespace

void choose_radius(const CloudSettings& settings, LoadedCloud& cloud, const Progress& progress) {
  const std::optional<AdaptedRadius>& adapted = settings.adapted_radius;
  const std::optional<double> given = adapted ? adapted->max : settings.radius;
  if (given) positive(*given, adapted ? "greatest radius of points" : "radius of points");
  cloud.radius = given ? *given : automatic_radius(cloud.octree, settings.max_level);
  if (!adapted) return;
  if (settings.max_level < k_max_level) {
    throw Error(
        {.problem = "adapted radii of some levels of a cloud",
         .expected = "one radius for all points, or all levels: spacings are those of the whole cloud"});
  }
  cloud.spacing_factor = positive(adapted->factor, "factor between spacings and radii");
  if (!given) cloud.radius *= k_widest_over_automatic;
  cloud.octree = with_spacings(cloud.octree, adapted->neighbours, progress);
}

std::optional<SphereAround> sphere_around(const LoadedCloud& cloud, const glm::dvec3& place, int max_level) {
  if (cloud.spacing_factor == 0.0) {
    const auto around = find(cloud.octree, place, {.radius = cloud.radius, .k = 1, .max_level = max_level});
    if (around.empty()) return std::nullopt;
    return SphereAround{around.front().point_id, cloud.radius, around.front().distance};
  }
  // Every line through the place enters the spheres that the place lies in.
  const Ray line = make_ray(place, {0.0, 0.0, 1.0}, -cloud.radius, cloud.radius);
  std::optional<SphereAround> nearest;
  const RayQuery query{
      .radius = cloud.radius, .spacing_factor = cloud.spacing_factor, .max_level = max_level};
  for (const Hit& hit : find(cloud.octree, line, query)) {
    const SphereAround sphere{hit.point_id, sphere_radius(query, hit),
                              std::sqrt(hit.t * hit.t + hit.distance * hit.distance)};
    if (sphere.distance <= sphere.radius && (!nearest || sphere.distance < nearest->distance))
      nearest = sphere;
  }
  return nearest;
}

}  // namespace alidade
