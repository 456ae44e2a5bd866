// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "octree/tree_walk.h"
#include "renderer/disc_tracer.h"
#include "surface/brute_force_surface.h"
#include "surface/point_disc.h"
#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"

// Small clouds of discs, and their points as the plain loops of definitions take them.

namespace alidade::test {

/// A wall, a floor that ends at it, and points without a sheet.
inline std::vector<glm::dvec3> corner_points(Random& random, int count) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(random.between(0, 4), random.between(0, 4), 0.002 * random.in_cube().z);
    points.emplace_back(random.between(0, 4), 4.0 + 0.002 * random.in_cube().z, random.between(0, 3));
    if (i % 10 == 0) points.push_back(glm::dvec3(2, 2, 1.5) + 1.2 * random.in_cube());
  }
  return points;
}

inline LoadedCloud disc_cloud(const std::vector<glm::dvec3>& points, Random& random,
                              const std::optional<AdaptedRadius>& radius = {}) {
  LoadedCloud cloud = loaded(points, 0.1, {glm::dvec3(1e-4), glm::dvec3(0)});
  for (Color16& color : cloud.colors) color = Color16(static_cast<std::uint16_t>(random.bits()));
  CloudSettings settings;
  settings.shape = PointShape::blend;
  settings.adapted_radius = radius;
  choose_radius(settings, cloud);
  return cloud;
}

/// The points of a cloud in the order of the storage indices, with all that discs are made of.
struct PlainPoints {
  explicit PlainPoints(const LoadedCloud& loaded)
      : octree(with_surfaces(loaded.octree)),
        layers(octree.layers()),
        query{.radius = loaded.radius,
              .spacing_factor = loaded.spacing_factor,
              .discs = DiscQuery{.lone_radius = loaded.lone_radius}},
        spacings(spacings_by_id(loaded.octree)) {
    const TreeView& tree = octree.view();
    cloud.lattice = tree.lattice;
    cloud.positions = positions_in_order(tree);
    for (std::uint32_t index = 0; index < tree.point_count; ++index) ids.push_back(point_id(tree, index));
  }

  const Octree octree;
  const PointLayers& layers;
  const SurfaceQuery query;
  const std::vector<double> spacings;  ///< by id
  PointCloud cloud;
  std::vector<std::uint64_t> ids;  ///< by storage index
};

/// Normals of one sheet deviate by at most 32 degrees.
constexpr double k_sheet_cosine = 0.848;

/// The first crossing by its definition (renderer/disc_tracer.h).
inline std::optional<Hit> first_crossing(const PlainPoints& points, const Ray& ray,
                                         const SheetOrigin& origin) {
  SurfaceQuery query = points.query;
  query.filter = [&](const Candidate& candidate) {
    return !candidate.disc || origin.reach == 0.0f ||
           !is_part_of_surface(*candidate.disc, ray.origin, origin.reach, origin.thickness) ||
           std::fabs(glm::dot(candidate.disc->normal, origin.normal)) < k_sheet_cosine;
  };
  return brute_force::closest(points.cloud, ray, query, points.spacings, points.layers);
}

}  // namespace alidade::test
