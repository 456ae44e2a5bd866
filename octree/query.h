// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "octree/hit.h"
#include "octree/ray.h"

// Ray queries on raw points. Radius and interval are chosen per query; nothing of them is built into the
// index.
//
//   const Octree octree = build(cloud);
//   const Ray ray = make_ray({690000, 5325000, 600}, {0, 1, -0.1}, 0.0);
//   if (std::optional<Hit> hit = closest(octree, ray, {.radius = 0.05})) use(hit->point_id, hit->entry);

namespace alidade {

class Octree;

/// What orders the points that a ray passes.
enum class Measure {
  t,      ///< place of the projection (the paper's "closest")
  entry,  ///< where the ray enters the sphere of the query's radius around the point
};

/// Conditions of a ray query; all hold together (conjunction).
struct RayQuery {
  /// Points with distance <= radius (inclusive) count. REQUIRED: finite and >= 0, in metres.
  double radius = 0.0;
  Measure measure = Measure::entry;
  /// Only spheres that the ray enters at or after this place (entry >= entry_min, inclusive). The default
  /// admits spheres the ray starts in, whose entry lies before t_min. A renderer sets a small positive value:
  /// rays that leave a surface then never hit it again.
  double entry_min = -std::numeric_limits<double>::infinity();
};

/// The point with the smallest measure among those with distance <= radius, t_min <= t <= t_max (the ray's
/// closed interval, on the projection t whatever the measure) and entry >= entry_min. Equal measures: the
/// lowest point id. Empty octree or empty interval: no hit. The answer equals brute_force::closest bit for
/// bit. Cost: a few hundred nanoseconds to microseconds; grows with the number of points in the ray's
/// cylinder before the hit. Requires: ray made by make_ray (unit direction). Errors: radius negative or not
/// finite.
std::optional<Hit> closest(const Octree& octree, const Ray& ray, const RayQuery& query);

/// Whether any point fulfils the conditions of `closest`; stops at the first it finds.
bool occluded(const Octree& octree, const Ray& ray, const RayQuery& query);

/// The same for many rays in parallel (oneTBB, as many threads as the caller's arena allows).
/// Answers in the order of the rays. Errors: as above; `hits` or `answers` not as long as `rays`.
void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits);
void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers);

}  // namespace alidade
