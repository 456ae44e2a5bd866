// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// What a traversal needs of a ray, computed once in double.
///
/// Boxes are tested in float against slabs widened by radius + error, where `error` exceeds everything that
/// can go wrong between the float test and the double decision. With F the width of the root's frame (at
/// least 256 steps), W the largest coordinate and `way` the distance from the origin to the far end of the
/// points, all in metres, it is the sum of
/// - 2^-21 (F + radius): three roundings of 2^-24 on terms up to 2 F + 2 radius; it also pays for the
/// rounding of
///   scale * steps in world coordinates, at most 2^-22 steps;
/// - 2^-48 (W + way): cancellation in point - origin and in t;
/// - 4e-12 way: direction components are kept 1e-12 away from zero, which turns the ray by as much.
/// Local t counts from `shift`, where the ray enters the root's box, so that origins far away cost no
/// precision.
struct RaySetup {
  bool misses = false;      ///< the ray does not come near the root's box
  bool exhaustive = false;  ///< lengths beyond what floats can square: no pruning is safe
  double shift = 0.0;
  glm::dvec3 origin{0.0};   ///< ray.position(shift), relative to the world position of the root's corner
  glm::dvec3 inverse{0.0};  ///< 1 / direction
  glm::dvec3 reach{0.0};    ///< (radius + error) * |inverse|: widening of a slab, in t
  double double_error = 0.0;
  double widest_scale = 0.0;
  float direction[3];
  float scale[3];
  int near_row[3];  ///< row of Node bytes (0..2 low, 3..5 high) that the ray meets first, per axis
  int far_row[3];
  float t_low = 0.0f;  ///< local t below which nothing counts
};

/// 2^exponent for exponents of normal numbers, without the library call.
inline double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

/// Rounds towards +infinity with a little room, for upper limits that must not discard too much.
inline float float_above(double value) {
  const auto f = static_cast<float>(value);
  return f + std::fabs(f) * 0x1p-22f + std::numeric_limits<float>::min();
}

inline float float_below(double value) {
  return -float_above(-value);
}

inline RaySetup set_up(const TreeView& tree, const Ray& ray, const RayQuery& query) {
  RaySetup setup;
  const glm::dvec3 corner = to_world(tree.lattice, tree.base);
  const glm::dvec3 size = tree.bounds.size();
  const glm::dvec3& scale = tree.lattice.scale;
  setup.widest_scale = std::max({scale.x, scale.y, scale.z});
  const double frame_width = setup.widest_scale * power_of_two(tree.root_level);

  double largest = 0.0, way = query.radius + size.x + size.y + size.z;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max({largest, std::fabs(ray.origin[axis]), std::fabs(tree.bounds.min[axis]),
                        std::fabs(tree.bounds.max[axis])});
    way += std::fabs(ray.origin[axis] - tree.bounds.min[axis]);
  }
  setup.double_error = 0x1p-48 * (largest + way) + 4e-12 * way + 1e-30;
  const double error = setup.double_error + 0x1p-21 * (frame_width + query.radius);
  setup.exhaustive = !(frame_width + query.radius + largest + way < 1e16);
  if (setup.exhaustive) return setup;

  const double widening = query.radius + error;
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    // The sign is taken here and nowhere else, so that -0.0 cannot be seen differently in two places.
    const double d = ray.direction[axis];
    const bool negative = d < 0.0;
    setup.inverse[axis] = 1.0 / (negative ? std::min(d, -1e-12) : std::max(d, 1e-12));
    setup.reach[axis] = widening * std::fabs(setup.inverse[axis]);
    setup.near_row[axis] = negative ? 3 + axis : axis;
    setup.far_row[axis] = negative ? axis : 3 + axis;
    setup.direction[axis] = static_cast<float>(d);
    setup.scale[axis] = static_cast<float>(scale[axis]);
    const double near_face = negative ? tree.bounds.max[axis] : tree.bounds.min[axis];
    const double far_face = negative ? tree.bounds.min[axis] : tree.bounds.max[axis];
    enter = std::max(enter, (near_face - ray.origin[axis]) * setup.inverse[axis] - setup.reach[axis]);
    leave = std::min(leave, (far_face - ray.origin[axis]) * setup.inverse[axis] + setup.reach[axis]);
  }
  setup.misses = enter > leave;
  setup.shift = enter;
  setup.origin = (ray.origin - corner) + enter * ray.direction;
  setup.t_low = float_below(std::max(ray.t_min, query.entry_min) - enter - error);
  return setup;
}

}  // namespace alidade::simd
