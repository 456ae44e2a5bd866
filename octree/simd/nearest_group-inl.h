// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_NEAREST_GROUP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_NEAREST_GROUP_INL_H
#undef ALIDADE_SIMD_NEAREST_GROUP_INL_H
#else
#define ALIDADE_SIMD_NEAREST_GROUP_INL_H
#endif

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "octree/query_targets.h"
#include "octree/simd/box_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// The k nearest points of targets that are close together: one walk through the tree collects the points
/// around all of them, which are then compared with each target, without a tree. What this does not settle is
/// left to a search of its own.
///
/// Positions are relative to the centre of the collected region, whose half width on its widest axis is E.
/// `error_` exceeds what can go wrong between a float distance and the double one that decides, in units of
/// 2^-24: coordinates E each for point and target and 2 E for their difference, the norm of three of them
/// 7 E; squares, sum and root 6 E. The budget is 32 E, and 1e-18 where squares leave the range of floats.
class NearestGroup {
 public:
  static constexpr std::size_t k_most_targets = 32;

  NearestGroup(const TreeView& tree, const PointQuery& query, std::size_t k)
      : tree_(tree), query_(query), k_(k) {}

  /// Collects all points up to `reach` from any of these targets. False: they are too many.
  bool collect(std::span<const glm::dvec3> targets, double reach) {
    Bounds region;
    for (const glm::dvec3& target : targets) region.grow(target);
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      largest = std::max({largest, std::fabs(region.min[axis]), std::fabs(region.max[axis])});
    // The distances that decide are rounded, and so are the faces; squares of lengths below 1e-154 vanish.
    const double margin = reach * (1.0 + 0x1p-40) + 0x1p-50 * largest + 1e-150;
    double width = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      region.min[axis] -= margin;
      region.max[axis] += margin;
      width = std::max(width, region.max[axis] - region.min[axis]);
    }
    if (!(width < k_widest)) return false;
    reach_ = reach;
    center_ = region.center();
    error_ = float_above(0x1p-20 * width + 1e-18);
    count_ = 0;
    const LatticeBox box(tree_, region);
    if (!box.empty()) BoxWalk(tree_, box, query_.max_level, *this).run();
    if (is_done()) return false;
    for (std::size_t i = 0; i < count_; ++i) {
      const glm::dvec3 position = to_world(tree_.lattice, points_.stored[i].position);
      for (int axis = 0; axis < 3; ++axis)
        points_.local[axis][i] = static_cast<float>(position[axis] - center_[axis]);
      points_.position[i] = position;
    }
    for (int axis = 0; axis < 3; ++axis) std::fill_n(points_.local[axis] + count_, k_lanes, 1e18f);
    return true;
  }

  /// Appends the answers of one of the targets. False, and nothing appended: there are points that were not
  /// collected among them, or too many to choose from.
  bool find(const glm::dvec3& target, std::vector<PointHit>& answers) {
    const std::size_t near_count = find_near(target);
    // All points in the query's radius were collected.
    const bool is_complete = query_.radius <= reach_;
    if (near_count > k_most_near || (near_count < k_ && !is_complete)) return false;
    const std::size_t first = answers.size();
    decide(target, near_count, answers);
    const std::size_t found = answers.size() - first;
    if (found > k_) answers.resize(first + k_);
    if (is_complete || (found >= k_ && answers.back().distance <= reach_)) return true;
    answers.resize(first);
    return false;
  }

  // As BoxWalk calls it.
  bool is_done() const { return count_ + k_max_leaf_size > k_most_points; }
  bool all(const Frame&, int) const { return false; }
  void leaf(const Leaf& leaf, std::uint32_t bits) {
    count_ += unpack(tree_, leaf, bits, points_.stored + count_);
  }

 private:
  static constexpr std::size_t k_lanes = 16;  ///< at least those of PointLanes
  static constexpr double k_widest = 1e15;    ///< metres; floats hold squares of such lengths
  static constexpr std::size_t k_most_points = 2048;
  static constexpr std::size_t k_most_near = 256;  ///< the distance of each is compared with all

  // Without initial values: they would take longer than a small group.
  struct Points {
    alignas(64) float local[3][k_most_points + k_lanes];
    alignas(64) float near_sq[k_most_near + 2 * k_lanes];  ///< squares of distances
    alignas(64) std::int32_t near[k_most_near + 2 * k_lanes];
    alignas(64) std::int32_t rank[k_most_near + 2 * k_lanes];
    std::int32_t order[k_most_near];
    StoredPoint stored[k_most_points + k_unpack_room];
    glm::dvec3 position[k_most_points];
  };

  /// Finds the collected points that may lie within reach and radius; how many.
  std::size_t find_near(const glm::dvec3& target) {
    const PointLanes d;
    const hn::RebindToSigned<PointLanes> ints;
    Points& points = points_;
    const float outer = at_least(std::min(reach_, query_.radius)) + error_;
    const auto outer_sq = hn::Set(d, outer * outer * k_up);
    const auto x = hn::Set(d, static_cast<float>(target.x - center_.x)),
               y = hn::Set(d, static_cast<float>(target.y - center_.y)),
               z = hn::Set(d, static_cast<float>(target.z - center_.z));
    const auto step = hn::Set(ints, static_cast<std::int32_t>(hn::Lanes(d)));
    auto indices = hn::Iota(ints, 0);
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_ && count <= k_most_near;
         i += hn::Lanes(d), indices = hn::Add(indices, step)) {
      const auto dx = hn::Sub(hn::Load(d, points.local[0] + i), x),
                 dy = hn::Sub(hn::Load(d, points.local[1] + i), y),
                 dz = hn::Sub(hn::Load(d, points.local[2] + i), z);
      const auto distance_sq = hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)));
      const auto is_near = hn::Le(distance_sq, outer_sq);
      if (hn::AllFalse(d, is_near)) continue;
      const Compressor compress(d, is_near);
      hn::StoreU(compress(distance_sq), d, points.near_sq + count);
      hn::StoreU(compress(indices), ints, points.near + count);
      count += compress.count();
    }
    return count;
  }

  /// Appends those of the near points that are first, in order, and maybe some more.
  void decide(const glm::dvec3& target, std::size_t near_count, std::vector<PointHit>& answers) {
    const std::size_t candidates = put_in_order(near_count);
    const PointTarget decider(target, query_);
    const std::size_t first = answers.size();
    for (std::size_t i = 0; i < candidates; ++i) {
      const auto point = static_cast<std::size_t>(points_.near[points_.order[i]]);
      const auto answer =
          decider.evaluate(points_.position[point], point_id(tree_, points_.stored[point].index));
      if (!answer) continue;
      answers.push_back(*answer);
      for (std::size_t at = answers.size() - 1; at > first && decider.precedes(answers[at], answers[at - 1]);
           --at)
        std::swap(answers[at], answers[at - 1]);
    }
  }

  /// Fills `order` with near points by their float distances. How many of them may be among the k first.
  std::size_t put_in_order(std::size_t near_count) {
    const PointLanes d;
    const hn::RebindToSigned<PointLanes> ints;
    Points& points = points_;
    std::fill_n(points.near_sq + near_count, k_lanes, std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < near_count; i += hn::Lanes(d)) {
      const auto distances = hn::Load(d, points.near_sq + i);
      auto rank = hn::Zero(ints);
      for (std::size_t j = 0; j < near_count; ++j) {
        const auto is_behind = hn::RebindMask(ints, hn::Lt(hn::Set(d, points.near_sq[j]), distances));
        rank = hn::Add(rank, hn::IfThenElseZero(is_behind, hn::Set(ints, 1)));
      }
      hn::Store(rank, ints, points.rank + i);
    }
    std::fill_n(points.order, near_count, -1);
    for (std::size_t i = 0; i < near_count; ++i) {
      std::int32_t at = points.rank[i];
      while (points.order[at] >= 0) ++at;  // of equal distances
      points.order[at] = static_cast<std::int32_t>(i);
    }
    if (near_count <= k_) return near_count;
    const float limit = std::sqrt(points.near_sq[points.order[k_ - 1]]) + 2.0f * error_,
                limit_sq = limit * limit * k_up;
    std::size_t candidates = k_;
    while (candidates < near_count && points.near_sq[points.order[candidates]] <= limit_sq) ++candidates;
    return candidates;
  }

  const TreeView& tree_;
  const PointQuery& query_;
  const std::size_t k_;
  double reach_ = 0.0;
  glm::dvec3 center_{0.0};
  float error_ = 0.0f;
  std::size_t count_ = 0;
  Points points_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
