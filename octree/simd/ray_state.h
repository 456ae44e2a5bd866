// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/tree_walk.h"

namespace alidade::simd {

/// 2^exponent for exponents of normal numbers, without the library call.
inline double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

/// Rounds towards +infinity with a little room, for upper limits that must not discard too much.
inline float float_above(double value) {
  const auto f = static_cast<float>(std::clamp(value, -1e30, 1e30));
  return f + std::fabs(f) * 0x1p-22f + std::numeric_limits<float>::min();
}

inline float float_below(double value) {
  return -float_above(-value);
}

/// What a traversal needs of tree and query, the same for all rays of a batch.
///
/// Boxes are tested in float against the ray's line widened by `box_radius`, which exceeds the radius by more
/// than everything that can go wrong between the float test and the double decision. With F the width of the
/// root's frame and r the radius, all places relative to the root's corner, in units of 2^-24: rounding of
/// the lattice's scale, of 1/d and of their products with corner and grid step at most 4 F (corner and grid
/// steps together stay below F), of the ray's local origin F + r, of the three sums in t at most 6 F + 5 r,
/// of the widening 4 r. The sum stays below 11 (F + r); the budget is 16 (F + r). What goes wrong in double
/// differs from ray to ray and is added there (RayState::double_error).
struct QuerySetup {
  QuerySetup(const TreeView& asked_tree, const RayQuery& asked_query)
      : tree(asked_tree), query(asked_query), corner(to_world(asked_tree.lattice, asked_tree.base)) {
    const glm::dvec3& scale = tree.lattice.scale;
    widest_scale = std::max({scale.x, scale.y, scale.z});
    frame_width = widest_scale * power_of_two(tree.root_level);
    box_radius = query.radius + 0x1p-20 * (frame_width + query.radius);
    stream_error = 0x1p-22 * (frame_width + query.radius);
    for (int axis = 0; axis < 3; ++axis) float_scale[axis] = static_cast<float>(scale[axis]);
  }

  const TreeView& tree;
  const RayQuery& query;
  glm::dvec3 corner;  ///< world position of the root's corner
  double widest_scale = 0.0;
  double frame_width = 0.0;
  double box_radius = 0.0;
  double stream_error = 0.0;  ///< largest RayState::double_error of rays that go through the tree together
  float float_scale[3];
};

/// The best point so far of a ray.
struct Best {
  Leaf leaf;
  std::uint32_t index = 0;  ///< within the leaf
};

/// A ray under way. Places on it are told by local t, which counts from where the ray enters the root's box,
/// so that origins far away cost no precision.
struct alignas(64) RayState {
  // For boxes, in float. t of a face at x is x * inverse - origin_t.
  float inverse[4];          ///< 1 / direction, components kept 1e-12 away from zero
  float origin_t[4];         ///< local origin * inverse
  float t_low;               ///< nothing that ends before counts
  float t_cut;               ///< nothing that begins after counts
  std::uint32_t number = 0;  ///< of the ray in its batch
  bool misses = false;       ///< does not come near the root's box, or its interval is empty
  bool exhaustive = false;   ///< lengths beyond what floats can square: no pruning is safe
  bool found = false;
  std::uint8_t octant = 0;  ///< bit per axis: direction is negative
  // For leaves, in double.
  double origin[3];  ///< ray.position(shift) from the root's corner
  double direction[3];
  /// Exceeds what goes wrong in double and by keeping directions away from zero: 2^-48 (W + way) + 4e-12 way,
  /// W the largest coordinate, `way` that from the ray's origin to the far end of the points.
  double double_error;
  double shift;
  double t_min, t_max, entry_min;  ///< local
  /// The best point's measure lies in [best_low, cut], local t. They are equal but for rounding once it was
  /// decided in double.
  double best_low = std::numeric_limits<double>::infinity();
  double cut;
  Best best;

  void cut_at(double t) {
    cut = t;
    t_cut = float_above(t);
  }
};

inline void set_up(const QuerySetup& setup, const Ray& ray, std::uint32_t number, RayState& state) {
  const Bounds& bounds = setup.tree.bounds;
  const double radius = setup.query.radius;
  double largest = 0.0, way = radius;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max(
        {largest, std::fabs(ray.origin[axis]), std::fabs(bounds.min[axis]), std::fabs(bounds.max[axis])});
    way += std::fabs(ray.origin[axis] - bounds.min[axis]) + (bounds.max[axis] - bounds.min[axis]);
  }
  state.number = number;
  state.double_error = 0x1p-48 * (largest + way) + 4e-12 * way + 1e-30;
  state.exhaustive = !(setup.frame_width + radius + largest + way < 1e16);
  if (state.exhaustive) return;

  const double widening = setup.box_radius + state.double_error;
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  double inverse[3];
  for (int axis = 0; axis < 3; ++axis) {
    // The sign is taken here and nowhere else, so that -0.0 cannot be seen differently in two places.
    const double d = ray.direction[axis];
    const bool negative = d < 0.0;
    if (negative) state.octant |= static_cast<std::uint8_t>(1u << axis);
    inverse[axis] = 1.0 / (negative ? std::min(d, -1e-12) : std::max(d, 1e-12));
    state.inverse[axis] = static_cast<float>(inverse[axis]);
    state.direction[axis] = d;
    const double near_face = negative ? bounds.max[axis] + widening : bounds.min[axis] - widening;
    const double far_face = negative ? bounds.min[axis] - widening : bounds.max[axis] + widening;
    enter = std::max(enter, (near_face - ray.origin[axis]) * inverse[axis]);
    leave = std::min(leave, (far_face - ray.origin[axis]) * inverse[axis]);
  }
  state.shift = enter;
  for (int axis = 0; axis < 3; ++axis) {
    state.origin[axis] = (ray.origin[axis] - setup.corner[axis]) + enter * ray.direction[axis];
    state.origin_t[axis] = static_cast<float>(state.origin[axis] * inverse[axis]);
  }
  state.t_min = ray.t_min - enter;
  state.t_max = ray.t_max - enter;
  state.entry_min = setup.query.entry_min - enter;
  state.t_low = float_below(std::max(state.t_min, state.entry_min) - widening);
  state.cut_at(state.t_max + state.double_error);
  state.misses = enter > leave || !(state.t_low <= state.t_cut);
}

}  // namespace alidade::simd
