// SPDX-License-Identifier: MIT
#pragma once

#include <type_traits>

#include "octree/query.h"

// The entrance of every query: what is refused, with what is wrong. Index and brute force ask here before
// they look at a point. Nothing returned means: good.

namespace alidade {

/// Errors: k = 0; radius negative or NaN; spacing_factor negative or not finite; entry_min NaN;
/// Measure::entry with an infinite radius; max_level negative.
void check(const RayQuery& query);
void check(const ConeQuery& query);
/// Errors beside those: Measure::entry.
void check(const PathQuery& query);
void check(const PointQuery& query);
/// For boxes and half-spaces. Errors beside those: a radius.
void check_without_radius(const PointQuery& query);

/// Errors: what make_ray and its like promise does not hold: numbers not finite, a direction or normal whose
/// length is not 1 within 1e-6, limits NaN; of cones: radius or slope negative; of paths: fewer than two
/// vertices, vertex_t not the way along the vertices; of boxes: a NaN (infinite and inverted boxes are fine).
void check(const Ray& ray);
void check(const Cone& cone);
void check(const Path& path);
void check(const HalfSpaces& region);
void check(const Bounds& box);
void check(const glm::dvec3& point);

/// The query, by the rules of the target's family.
template <class Target, class Query>
void check_conditions(const Query& query) {
  constexpr bool has_no_radius = std::is_same_v<Target, Bounds> || std::is_same_v<Target, HalfSpaces>;
  if constexpr (has_no_radius) {
    check_without_radius(query);
  } else {
    check(query);
  }
}

/// Query and target together, by the rules of their family.
template <class Target, class Query>
void check_target(const Target& target, const Query& query) {
  check_conditions<Target>(query);
  check(target);
}

/// Errors: max_level for an octree that has points and is not layered.
void check_level(const Octree& octree, int max_level);

/// Errors: spacing_factor for an octree that has points and no spacings.
void check_spacings(const Octree& octree, const RayQuery& query);

/// Errors: room for answers that is not as long as the targets.
void check_room(std::size_t targets, std::size_t room);

}  // namespace alidade
