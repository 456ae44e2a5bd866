// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "octree/brute_force.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/point_surface.h"
#include "surface/surface_cloud.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/same_hits.h"

// Clouds of discs, and queries of clouds whose points have radii of their own.

namespace alidade::test {

/// Beside an answer by brute force, which is without a storage index.
inline ::testing::AssertionResult same_hits(const std::optional<SurfaceHit>& found,
                                            const std::optional<Hit>& expected) {
  return same_hits(std::optional<Hit>(found), expected);
}
inline ::testing::AssertionResult same_hits(const std::optional<SurfaceHit>& found,
                                            const std::optional<SurfaceHit>& expected) {
  if (found == expected) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "another point, or another storage index: "
                                       << same_hits(found, std::optional<Hit>(expected)).message();
}

/// Whether the storage index of a hit is that of its point.
inline bool has_right_index(const SurfaceCloud& cloud, const std::optional<SurfaceHit>& hit) {
  return !hit || point_id(cloud.view().tree, hit->index) == hit->point_id;
}

/// The same conditions of points with radii of their own.
inline SurfaceQuery with_own_radii(const RayQuery& query, double spacing_factor) {
  return {.radius = query.radius,
          .spacing_factor = spacing_factor,
          .measure = query.measure,
          .entry_min = query.entry_min,
          .filter = query.filter};
}

/// The same conditions of discs, with any factor, lone points and edges.
inline SurfaceQuery disc_query(const RayQuery& from, Random& random) {
  constexpr double k_factors[] = {0.1, 0.92, 3.0, 1e6};
  SurfaceQuery query = with_own_radii(from, k_factors[random.below(4)]);
  if (std::isinf(query.radius)) query.radius = 1e9;
  DiscQuery& discs = query.discs.emplace();
  if (random.below(2) == 0) discs.lone_factor = random.between(0.0, 2.0);
  if (random.below(2) == 0) discs.edge_shift = random.between(-0.5, 0.5);
  if (random.below(2) == 0) discs.lone_radius = query.radius * random.between(0.0, 0.5);
  return query;
}

/// A ray that Algorithm 1 answers: its direction is a little longer than lanes take it to be.
inline Ray beside_lanes(Ray ray) {
  ray.direction *= 1.0 + 1e-9;
  return ray;
}

/// The octree with random surfaces, equal ones at equal positions: three in four points have one, half of
/// them an edge.
inline Octree with_random_surfaces(const Octree& octree) {
  struct Arrays {
    std::vector<std::uint32_t> surfaces;
    std::vector<std::uint8_t> edges;
  };
  const auto made = std::make_shared<Arrays>();
  for (const LatticePosition& position : positions_in_order(octree.view())) {
    std::uint64_t bits = 0x9e3779b97f4a7c15u;
    for (int axis = 0; axis < 3; ++axis) {
      bits = (bits ^ static_cast<std::uint32_t>(position[axis])) * 0xff51afd7ed558ccdu;
      bits ^= bits >> 32;
    }
    made->surfaces.push_back(static_cast<std::uint32_t>(bits) | static_cast<std::uint32_t>(bits >> 32) << 31);
    made->edges.push_back(static_cast<std::uint8_t>((bits >> 40 & 1) == 0 ? 0 : 32 + (bits >> 41) % 224));
  }
  PointLayers layers = octree.layers();
  layers.surfaces = made->surfaces.data();
  layers.sheet_edges = made->edges.data();
  layers.surface_unit = 0.1 * automatic_radius(octree);
  return octree.with_layers(layers, made);
}

/// Two walls that meet, a floor that ends, coarse beside fine, and points beside them.
inline PointCloud sheets(Random& random) {
  const glm::dvec3 site(690000.0, 5325000.0, 300.0);
  std::vector<glm::dvec3> points;
  const auto add = [&](double x, double y, double z) { points.push_back(site + glm::dvec3(x, y, z)); };
  for (int i = 0; i < 400; ++i) {
    add(random.between(0, 4), random.between(0, 4), 0.002 * random.in_cube().z);
    add(random.between(0, 4), 4.0 + 0.002 * random.in_cube().z, random.between(0, 3));
    add(4.0, random.between(0, 4), random.between(0, 0.2));
    if (i % 10 == 0) add(random.between(0, 4), random.between(0, 4), random.between(0.2, 3.0));
  }
  return make_cloud(points, {glm::dvec3(1e-4), site});
}

struct DiscCase {
  std::string name;
  PointCloud cloud;
  bool fitted = true;              ///< surfaces are fitted, not random
  std::vector<double> spacings{};  ///< by point id

  /// Octree: of the cloud.
  Octree with_all(const Octree& octree) const {
    const Octree spaced = with_spacings(octree, k_surface_neighbours);
    return fitted ? with_surfaces(spaced) : with_random_surfaces(spaced);
  }
};

/// Made once: each spacing looks at every point.
inline const std::vector<DiscCase>& disc_cases() {
  static const std::vector<DiscCase> made = [] {
    std::vector<DiscCase> cases;
    Random random("sheets");
    const PointCloud cloud = sheets(random);
    cases.push_back({"fitted sheets", cloud, true});
    cases.push_back({"random sheets", cloud, false});
    // Doubles of its coordinates are as coarse as its lattice.
    const glm::dvec3 site(690000.0, 5325000.0, 300.0);
    std::vector<glm::dvec3> grain;
    for (int i = 0; i < 1000; ++i) grain.push_back(site + 1e-4 * random.in_cube());
    cases.push_back({"grain", make_cloud(grain, {glm::dvec3(1e-9), site}), false});
    for (const PointFamily& family : point_families()) cases.push_back({family.name, family.cloud, false});
    for (DiscCase& one : cases) one.spacings = brute_force::spacings(one.cloud, k_surface_neighbours);
    return cases;
  }();
  return made;
}

}  // namespace alidade::test
