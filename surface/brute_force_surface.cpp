// SPDX-License-Identifier: MIT
#include "surface/brute_force_surface.h"

#include <algorithm>
#include <string>

#include "base/error.h"
#include "octree/check_query.h"
#include "surface/decide_point.h"

namespace alidade::brute_force {

std::vector<Hit> find(const PointCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                      std::span<const double> spacings, const PointLayers& layers) {
  check(query, 1);
  check(ray);
  if (spacings.size() != cloud.size()) {
    throw input_error("spacings do not match the points", std::to_string(cloud.size()),
                      std::to_string(spacings.size()));
  }
  if (query.discs && cloud.size() > 0 && layers.surfaces == nullptr)
    throw input_error("discs require the surfaces of the points", "layers with surfaces");
  std::vector<Hit> hits;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const double radius = own_radius(query, spacings[id]);
    const auto hit = query.discs ? evaluate_disc(ray, query, radius, surface_of(layers, id),
                                                 layers.sheet_edges[id], cloud.world(id), id, 0)
                                 : evaluate(ray, query, radius, cloud.world(id), id, 0);
    if (hit) hits.push_back(*hit);
  }
  std::ranges::sort(hits, [&](const Hit& a, const Hit& b) { return precedes(order_of(query), a, b); });
  return hits;
}

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                           std::span<const double> spacings, const PointLayers& layers) {
  const std::vector<Hit> hits = find(cloud, ray, query, spacings, layers);
  return hits.empty() ? std::nullopt : std::optional(hits.front());
}

}  // namespace alidade::brute_force
