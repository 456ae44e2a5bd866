// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "base/error.h"
#include "octree/query.h"

// What every query rejects, and why. Index and brute force call these functions before they read a point.
// They throw, or return nothing.

namespace alidade {

/// A position or direction as messages show it.
std::string text_of(const glm::dvec3& v);

/// Errors: k = 0; radius negative or NaN; entry_min NaN; Measure::entry with an infinite radius; max_level
/// negative.
void check(const RayQuery& query);
void check(const ConeQuery& query);
/// Errors beside those of cones and rays: Measure::entry.
void check(const PathQuery& query);
void check(const PointQuery& query);
/// For boxes and half-spaces. Errors beside those: a radius.
void check_without_radius(const PointQuery& query);
/// What queries of rays have in common. Errors: radius negative or NaN; entry_min NaN; Measure::entry with an
/// infinite radius.
void check_radius_along_ray(double radius, Measure measure, double entry_min);

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
  if constexpr (std::is_same_v<Query, PointQuery> && QueryFamily<Target>::limits_itself) {
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

/// Target, query, and what the query requires of the octree.
template <class Target, class Query>
void check_target(const Octree& octree, const Target& target, const Query& query) {
  check_target(target, query);
  check_level(octree, query.max_level);
}

/// Errors: room for answers that is not as long as the targets.
void check_room(std::size_t targets, std::size_t room);

/// Whether a target certainly passes check(); of few instructions, for many targets. Others may pass, too.
inline bool is_certainly_valid(const Ray& ray) {
  constexpr double k_finite = std::numeric_limits<double>::max();
  const glm::dvec3 &o = ray.origin, &d = ray.direction;
  return std::fabs(d.x * d.x + d.y * d.y + d.z * d.z - 1.0) <= 1e-6 && std::fabs(o.x) <= k_finite &&
         std::fabs(o.y) <= k_finite && std::fabs(o.z) <= k_finite && !std::isunordered(ray.t_min, ray.t_max);
}
template <class Target>
bool is_certainly_valid(const Target&) {
  return false;
}

/// Checks a target; the Error names its number.
template <class Target>
void check_numbered(std::span<const Target> targets, std::size_t i) {
  try {
    check(targets[i]);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.problem = std::string(QueryFamily<Target>::name) + " " + std::to_string(i) + ": " + parts.problem;
    throw Error(std::move(parts));
  }
}

/// Checks the targets from `first` to last - 1; the Error names the first invalid one.
template <class Target>
void check_range(std::span<const Target> targets, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i)
    if (!is_certainly_valid(targets[i])) check_numbered(targets, i);
}

}  // namespace alidade
