// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/point_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/query_targets.h"
#include "octree/simd/box_walk-inl.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/local_point-inl.h"
#include "octree/simd/nearest_first-inl.h"
#include "octree/spacing.h"

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
      const glm::dvec3 offset = to_world(tree_.lattice, points_.stored[i].position) - center_;
      for (int axis = 0; axis < 3; ++axis) points_.local[axis][i] = static_cast<float>(offset[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) std::fill_n(points_.local[axis] + count_, k_lanes, 1e18f);
    return true;
  }

  /// The distance from one of the targets to the n-th nearest point elsewhere, within `error` of it;
  /// n = k - 1. Empty where other points may be at its own position, or too few were collected.
  struct Spacing {
    double distance, error;
  };
  std::optional<Spacing> spacing(const glm::dvec3& target) {
    const std::size_t near_count = find_near(target);
    if (near_count < k_ || near_count > k_most_near) return std::nullopt;
    const PointLanes d;
    const hn::RebindToSigned<PointLanes> ints;
    const auto* const near_sq = points_.near_sq;
    std::fill_n(points_.near_sq + near_count, k_lanes, std::numeric_limits<float>::infinity());
    const auto all_but_one = hn::Set(ints, static_cast<std::int32_t>(k_ - 1));
    const float twin_sq = 4.0f * error_ * error_ * k_up;
    std::size_t at_target = 0;
    auto farthest_sq = hn::Zero(d);
    for (std::size_t i = 0; i < near_count; i += hn::Lanes(d)) {
      const auto distances_sq = hn::Load(d, near_sq + i);
      at_target += hn::CountTrue(d, hn::Le(distances_sq, hn::Set(d, twin_sq)));
      auto nearer = hn::Zero(ints);
      for (std::size_t j = 0; j < near_count; ++j) {
        const auto is_nearer = hn::RebindMask(ints, hn::Lt(hn::Set(d, near_sq[j]), distances_sq));
        nearer = hn::Add(nearer, hn::IfThenElseZero(is_nearer, hn::Set(ints, 1)));
      }
      const auto is_among = hn::RebindMask(d, hn::Not(hn::Gt(nearer, all_but_one)));
      farthest_sq = hn::Max(farthest_sq, hn::IfThenElseZero(is_among, distances_sq));
    }
    const double distance = std::sqrt(static_cast<double>(hn::GetLane(hn::MaxOfLanes(d, farthest_sq))));
    if (at_target != 1 || !(distance + error_ <= reach_)) return std::nullopt;
    return Spacing{distance, error_};
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
      // Which vectors hold none cannot be predicted, and compressing one is no slower, except in four lanes.
      if constexpr (hn::MaxLanes(PointLanes()) == 4)
        if (hn::AllFalse(d, is_near)) continue;
      const Compressor compress(d, is_near);
      hn::StoreU(compress(distance_sq), d, points.near_sq + count);
      hn::StoreU(compress(indices), ints, points.near + count);
      count += compress.count();
    }
    return count;
  }

  /// Appends those of the near points that are first, in order, and maybe some more; as evaluate()
  /// (octree/candidate.h) without a filter, but in place: copies of answers just written are slow.
  void decide(const glm::dvec3& target, std::size_t near_count, std::vector<PointHit>& answers) {
    const std::size_t candidates = put_in_order(near_count);
    const PointTarget decider(target, query_);
    const std::size_t first = answers.size();
    for (std::size_t i = 0; i < candidates; ++i) {
      const auto point = static_cast<std::size_t>(points_.near[points_.order[i]]);
      const StoredPoint& stored = points_.stored[point];
      const glm::dvec3 position = to_world(tree_.lattice, stored.position);
      const double distance = alidade::distance(target, position);
      if (!(distance <= query_.radius)) continue;
      PointHit& answer = answers.emplace_back();
      answer.point_id = point_id(tree_, stored.index);
      answer.position = position;
      answer.distance = distance;
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

/// Calls answer(target, group) for one target after another; the group has collected the points around it, or
/// is null. The answer is the distance up to which points of the next targets should be collected.
template <class AnswerOne>
void in_turn(const TreeView& tree, std::span<const glm::dvec3> targets, const PointQuery& query,
             std::size_t k, double& reach, const AnswerOne& answer) {
  constexpr std::size_t k_fewest = 4;  // smaller groups are searched singly
  constexpr double k_allowance = 1.15;
  NearestGroup group(tree, query, k);
  while (!targets.empty()) {
    const std::size_t count = group_size(targets, reach);
    const bool is_collected = count >= k_fewest && group.collect(targets.first(count), reach);
    double reaches[NearestGroup::k_most_targets] = {};
    for (std::size_t i = 0; i < count; ++i) reaches[i] = answer(targets[i], is_collected ? &group : nullptr);
    // Nine in ten, so that a few outliers do not make the next group collect too much.
    double* const most = reaches + count * 9 / 10;
    std::nth_element(reaches, most, reaches + count);
    reach = k_allowance * *most;
    targets = targets.subspan(count);
  }
}

void find_in_turn(const TreeView& tree, std::span<const glm::dvec3> targets, const PointQuery& query,
                  std::size_t k, double& reach, std::vector<PointHit>& answers,
                  std::vector<std::size_t>& ends) {
  const double reach_of_few = std::isinf(query.radius) ? 0.0 : query.radius;
  in_turn(tree, targets, query, k, reach, [&](const glm::dvec3& target, NearestGroup* group) {
    const std::size_t first = answers.size();
    if (group == nullptr || !group->find(target, answers)) find(tree, target, query, k, 0, answers);
    ends.push_back(answers.size());
    return answers.size() - first < k ? reach_of_few : answers.back().distance;
  });
}

void spacings_in_turn(const TreeView& tree, std::span<const glm::dvec3> targets, std::size_t n, double& reach,
                      std::uint16_t* spacings) {
  const PointQuery query{.k = n + 1};
  in_turn(tree, targets, query, query.k, reach, [&](const glm::dvec3& target, NearestGroup* group) {
    std::optional<NearestGroup::Spacing> found;
    if (group != nullptr) found = group->spacing(target);
    *spacings = k_unknown_spacing;
    if (found) {
      const std::uint16_t low = spacing_bits(std::max(found->distance - found->error, 0.0));
      if (low == spacing_bits(found->distance + found->error)) *spacings = low;
    }
    ++spacings;
    return found ? found->distance : reach;
  });
}

constexpr Search<glm::dvec3> k_point_search{find, count, find_in_turn, spacings_in_turn};

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
