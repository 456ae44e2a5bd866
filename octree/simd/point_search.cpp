// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/point_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/query_targets.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/local_point-inl.h"
#include "octree/simd/nearest_first-inl.h"
#include "octree/simd/nearest_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Distances to a point, for NearestFirst. Bounds are squares of distances. Boxes are widened by the error of
/// the point (LocalPoint), so that only the rounding of squares and sums is left, which `limit` allows for.
class PointKernel {
 public:
  using Local = LocalPoint::Local;

  PointKernel(const TreeView& tree, const glm::dvec3& point, double radius, bool filtered)
      : tree_(tree), point_(tree, point), radius_(at_least(radius)), all_in_double_(filtered) {
    if (std::isinf(radius)) radius_ = std::numeric_limits<float>::infinity();
    certain_radius_ = std::isinf(radius) ? radius_ : at_most(radius);
  }

  HWY_INLINE Local at(const std::array<std::uint32_t, 3>& corner, int level) const {
    return point_.at(corner, level);
  }

  HWY_INLINE float limit(float cut) const {
    const float distance = std::min(cut, radius_);
    return distance * distance * k_up;
  }

  template <bool tests_inside>
  HWY_INLINE void test_boxes(const Local& local, const Node& node, int level, float cut,
                             TestedBoxes& boxes) const {
    const ChildLanes d;
    const auto grid_step = static_cast<float>(power_of_two(level - k_min_frame_level));
    const auto limit_sq = hn::Set(d, limit(cut));
    const float inner = std::max(certain_radius_ - local.error, 0.0f);
    const auto inner_sq = hn::Set(d, inner * inner * k_down);
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      auto nearest_sq = hn::Zero(d), farthest_sq = hn::Zero(d);
      for (int axis = 0; axis < 3; ++axis) {
        const auto [to_low, from_high] = gaps_of(local, point_.scale(), grid_step, node, axis, lane);
        const auto gap = hn::Max(hn::Max(to_low, from_high), hn::Zero(d));
        nearest_sq = hn::MulAdd(gap, gap, nearest_sq);
        if constexpr (tests_inside) {
          const auto reach = hn::Neg(hn::Min(to_low, from_high));
          farthest_sq = hn::MulAdd(reach, reach, farthest_sq);
        }
      }
      hn::Store(nearest_sq, d, boxes.bound + lane);
      boxes.met |= mask_bits(d, hn::Le(nearest_sq, limit_sq)) << lane;
      if constexpr (tests_inside)
        if (!all_in_double_ && inner > 0.0f)
          boxes.inside |= mask_bits(d, hn::Le(farthest_sq, inner_sq)) << lane;
    }
  }

  HWY_INLINE void test_points(const Local& local, const Leaf& leaf, int level, float cut,
                              TestedPoints& points) const {
    const PointLanes d;
    const float error = local.error + LeafCoordinates::lost(level, point_.widest_scale());
    const float outer = std::min(cut, radius_) + error;
    const auto outer_sq = hn::Set(d, outer * outer * k_up);
    const auto inner = hn::Set(d, all_in_double_ ? -1.0f : certain_radius_);
    const auto float_error = hn::Set(d, error);
    const LeafCoordinates coordinates(tree_, leaf, level, point_.scale(), local.point);
    points.possible = points.certain = 0;
    for (int first = 0; first < coordinates.count; first += static_cast<int>(hn::Lanes(d))) {
      const auto x = coordinates(0, first), y = coordinates(1, first), z = coordinates(2, first);
      const auto distance_sq = hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x)));
      const unsigned bits = coordinates.in_leaf(hn::Le(distance_sq, outer_sq), first);
      if (bits == 0) continue;
      const auto distance = hn::Sqrt(distance_sq);
      const auto high = hn::Add(distance, float_error);
      hn::Store(hn::Sub(distance, float_error), d, points.low + first);
      hn::Store(high, d, points.high + first);
      points.possible |= bits << first;
      points.certain |= (mask_bits(d, hn::Le(high, inner)) & bits) << first;
    }
  }

 private:
  const TreeView& tree_;
  const LocalPoint point_;
  float radius_, certain_radius_;  ///< not below and not above the radius
  const bool all_in_double_;
};

void find(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
          std::size_t query_index, std::vector<PointHit>& answers) {
  const PointTarget target(point, query, query_index);
  const PointKernel kernel(tree, point, query.radius, static_cast<bool>(query.filter));
  if (k < tree.point_count) {
    find_first(tree, kernel, target, query, k, 0.0, 0.0, answers);
  } else {
    find_all(tree, kernel, target, query, answers);
  }
}

std::size_t count(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
                  std::size_t query_index) {
  const PointKernel kernel(tree, point, query.radius, !knows_all_points(query));
  return count_first(tree, kernel, PointTarget(point, query, query_index), query, k);
}

/// How many of the first targets are close together, measured by the distance of their k-th points.
std::size_t group_size(std::span<const glm::dvec3> targets, double reach) {
  constexpr double k_widest = 4.0;
  Bounds box;
  std::size_t count = 0;
  for (; count < std::min(targets.size(), NearestGroup::k_most_targets); ++count) {
    box.grow(targets[count]);
    const glm::dvec3 size = box.size();
    if (std::max({size.x, size.y, size.z}) > k_widest * reach) break;
  }
  return std::max<std::size_t>(count, 1);
}

void find_in_turn(const TreeView& tree, std::span<const glm::dvec3> targets, const PointQuery& query,
                  std::size_t k, double& reach, std::vector<PointHit>& answers,
                  std::vector<std::size_t>& ends) {
  constexpr std::size_t k_fewest = 4;  // smaller groups are searched singly
  constexpr double k_allowance = 1.15;
  NearestGroup group(tree, query, k);
  const double reach_of_few = std::isinf(query.radius) ? 0.0 : query.radius;
  while (!targets.empty()) {
    const std::size_t count = group_size(targets, reach);
    const bool is_collected = count >= k_fewest && group.collect(targets.first(count), reach);
    double reaches[NearestGroup::k_most_targets] = {};
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t first = answers.size();
      if (!is_collected || !group.find(targets[i], answers)) find(tree, targets[i], query, k, 0, answers);
      ends.push_back(answers.size());
      reaches[i] = answers.size() - first < k ? reach_of_few : answers.back().distance;
    }
    // Nine in ten, so that a few outliers do not make the next group collect too much.
    double* const most = reaches + count * 9 / 10;
    std::nth_element(reaches, most, reaches + count);
    reach = k_allowance * *most;
    targets = targets.subspan(count);
  }
}

constexpr Search<glm::dvec3> k_point_search{find, count, find_in_turn};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

template <>
const Search<glm::dvec3>& search(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_point_search)
}

bool suits_lanes(const TreeView& tree, const glm::dvec3& point, const PointQuery& query) {
  if (tree.node_count == 0) return false;
  double width = 0.0, away = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    width = std::max(width, tree.lattice.scale[axis] * power_of_two(tree.root_level));
    away = std::max({away, tree.bounds.min[axis] - point[axis], point[axis] - tree.bounds.max[axis]});
  }
  return width < 1e15 && away <= 64.0 * width && (query.radius < 1e15 || std::isinf(query.radius));
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
