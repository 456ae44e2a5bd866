// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_SET_UP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_SET_UP_INL_H
#undef ALIDADE_SIMD_RAY_SET_UP_INL_H
#else
#define ALIDADE_SIMD_RAY_SET_UP_INL_H
#endif

#include <hwy/highway.h>

#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// How a ray is to be traced.
enum class Course : std::uint8_t {
  misses,  ///< does not come near the points, or its interval is empty
  usual,
  far_away,  ///< needs a setup for a longer way
};

HWY_INLINE double clamped(double t) {
  return std::min(std::max(t, -k_far), k_far);
}

/// Fills boxes and state; nothing is found.
HWY_INLINE Course set_up(const QuerySetup& setup, const RayUnderWay& under_way) {
  const Ray& ray = under_way.asked;
  RayBoxes& boxes = under_way.boxes;
  RayState& state = under_way.state;
  state.best_low = std::numeric_limits<double>::infinity();
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  double inverse[3], way = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // The sign is taken here and nowhere else, so that -0.0 cannot be seen differently in two places.
    const double d = ray.direction[axis];
    const double sign = d < 0.0 ? -1.0 : 1.0;
    inverse[axis] = sign / std::max(std::fabs(d), 1e-12);
    const double below = setup.low_face[axis] - ray.origin[axis];
    const double above = setup.high_face[axis] - ray.origin[axis];
    way += std::max(std::fabs(below), std::fabs(above));
    enter = std::max(enter, std::min(below * inverse[axis], above * inverse[axis]));
    leave = std::min(leave, std::max(below * inverse[axis], above * inverse[axis]));
  }
  if (way > setup.longest_way) return Course::far_away;
  if (enter > leave) return Course::misses;
  state.shift = enter;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = (ray.origin[axis] - setup.corner[axis]) + enter * ray.direction[axis];
    boxes.inverse[axis] = static_cast<float>(inverse[axis]);
    boxes.origin_t[axis] = static_cast<float>(origin * inverse[axis]);
  }
  state.limits.t_min = clamped(ray.t_min - enter);
  state.limits.t_max = clamped(ray.t_max - enter);
  state.limits.entry_min = clamped(setup.query.entry_min - enter);
  state.limits.cut = state.limits.t_max + setup.double_error;
  boxes.t_low = float_below(std::max(state.limits.t_min, state.limits.entry_min) - setup.box_radius);
  boxes.t_cut = float_above(state.limits.cut);
  return boxes.t_low <= boxes.t_cut ? Course::usual : Course::misses;
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
