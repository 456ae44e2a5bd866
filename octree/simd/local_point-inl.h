// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LOCAL_POINT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LOCAL_POINT_INL_H
#undef ALIDADE_SIMD_LOCAL_POINT_INL_H
#else
#define ALIDADE_SIMD_LOCAL_POINT_INL_H
#endif

#include "octree/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// A point as the frames of nodes see it, for distances from it in float.
///
/// All positions are relative to the corner of a node's frame, whose width is W; D is the farthest the
/// point lies from there on an axis. `error` exceeds what can go wrong between a float distance and the
/// double one that decides, in units of 2^-24:
/// - a coordinate: rounding of scale, of the local point and of their difference, together 2 W + 2 D; the
///   norm of three of them 3.5 (W + D);
/// - squares, sum and root: 3 roundings of at most 1.8 (W + D), and as much again for limits on both sides;
///   together 7 (W + D). The sum stays below 11 (W + D); the budget is 16 (W + D).
/// - in double (offset, scale and steps to world coordinates; the point to local ones): 2^-48 of the largest
///   coordinate or offset;
/// - where squares leave the range of floats: 1e-18.
class LocalPoint {
 public:
  struct Local {
    float point[3];
    float error;
  };

  LocalPoint(const TreeView& tree, const glm::dvec3& point) : tree_(tree) {
    const glm::dvec3 corner = to_world(tree.lattice, tree.base);
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      point_[axis] = point[axis] - corner[axis];
      scale_[axis] = static_cast<float>(tree.lattice.scale[axis]);
      widest_scale_ = std::max(widest_scale_, tree.lattice.scale[axis]);
      largest = std::max({largest, std::fabs(point[axis]), std::fabs(corner[axis]),
                          std::fabs(tree.bounds.max[axis]), std::fabs(tree.lattice.offset[axis])});
    }
    double_error_ = 0x1p-48 * largest + 1e-18;
  }

  /// From the corner of a frame of this level.
  HWY_INLINE Local at(const std::array<std::uint32_t, 3>& corner, int level) const {
    Local local;
    double farthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double from_corner = point_[axis] - tree_.lattice.scale[axis] * corner[axis];
      farthest = std::max(farthest, std::fabs(from_corner));
      local.point[axis] = static_cast<float>(from_corner);
    }
    local.error =
        static_cast<float>(double_error_ + 0x1p-20 * (widest_scale_ * power_of_two(level) + farthest)) * k_up;
    return local;
  }

  /// Metres per lattice step.
  const float* scale() const { return scale_; }
  double widest_scale() const { return widest_scale_; }

 private:
  const TreeView& tree_;
  double point_[3];  ///< from the root's corner
  double widest_scale_ = 0.0, double_error_ = 0.0;
  float scale_[3];
};

/// How far a point lies outside of boxes on an axis, in lanes; below 0: inside. The boxes are those of a
/// node's slots, widened by the point's error.
struct Gaps {
  hn::Vec<ChildLanes> to_low, from_high;
};

HWY_INLINE Gaps gaps_of(const LocalPoint::Local& local, const float* scale, float grid_step, const Node& node,
                        int axis, std::size_t lane) {
  const ChildLanes d;
  const float step = scale[axis] * grid_step;
  // `high` is inclusive: its points are up to one lattice step below the next grid step.
  return {hn::MulAdd(load_as_float(d, node.low[axis] + lane), hn::Set(d, step),
                     hn::Set(d, -local.point[axis] - local.error)),
          hn::NegMulAdd(load_as_float(d, node.high[axis] + lane), hn::Set(d, step),
                        hn::Set(d, local.point[axis] - (step - scale[axis]) - local.error))};
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
