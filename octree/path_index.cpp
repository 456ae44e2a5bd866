// SPDX-License-Identifier: MIT
#include "octree/path_index.h"

#include <algorithm>
#include <bit>

namespace alidade {
namespace {

constexpr std::size_t k_group_size = 4;

// Deep enough for 2^63 groups: one child waits per level.
constexpr int k_stack_size = 64 + 1;

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Distances between the points of two boxes, widened so that they also hold for the distance to a segment
/// as project() computes it. With w the sum of the farthest coordinate differences and u = 2^-53, that errs
/// by at most 16 u w in the cross product and its norm, 3 u w in the segment's direction, and 8 u w where t
/// falls on the wrong side of an end; squares that underflow hide distances below 1e-153.
Interval distance_between(const Bounds& a, const Bounds& b) {
  std::array<Interval, 3> difference;
  double farthest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    difference[axis] = {a.min[axis] - b.max[axis], a.max[axis] - b.min[axis]};
    farthest += greatest_magnitude(difference[axis]);
  }
  const double allowance = 0x1p-47 * farthest + 1e-150;
  const Interval between = norm(difference[0], difference[1], difference[2]);
  return {between.low - allowance, between.high + allowance};
}

double diagonal_of(const Bounds& box) {
  return distance(box.min, box.max);
}

}  // namespace

PathIndex::PathIndex(const Path& path) : segments_(segments_of(path)) {
  leaf_count_ = std::bit_ceil((segments_.size() + k_group_size - 1) / k_group_size);
  groups_.resize(2 * leaf_count_);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    Group& group = groups_[leaf_count_ + i / k_group_size];
    if (group.bounds.empty()) group.t.low = segments_[i].t_begin;
    group.t.high = segments_[i].t_begin + segments_[i].length();
    group.bounds.grow(segments_[i].line.origin);
    group.bounds.grow(segments_[i].end);
  }
  for (std::size_t g = leaf_count_ - 1; g > 0; --g) {
    const Group &first = groups_[2 * g], &second = groups_[2 * g + 1];
    groups_[g].bounds = first.bounds;
    groups_[g].bounds.grow(second.bounds);
    groups_[g].t = {first.t.low, second.bounds.empty() ? first.t.high : second.t.high};
  }
  for (Group& group : groups_) group.diagonal = diagonal_of(group.bounds);
}

PathProjection PathIndex::project(const glm::dvec3& point) const {
  struct Open {
    double least;
    std::size_t group;
  };
  const Bounds point_box{point, point};
  const auto open = [&](std::size_t g) {
    return Open{distance_between(point_box, groups_[g].bounds).low, g};
  };

  PathProjection nearest;
  Open stack[k_stack_size];
  int count = 0;
  stack[count++] = open(1);
  while (count > 0) {
    const Open here = stack[--count];
    if (here.least > nearest.distance) continue;
    if (here.group < leaf_count_) {
      Open first = open(2 * here.group), second = open(2 * here.group + 1);
      if (first.least < second.least) std::swap(first, second);
      if (!groups_[first.group].bounds.empty()) stack[count++] = first;
      if (!groups_[second.group].bounds.empty()) stack[count++] = second;
      continue;
    }
    const std::size_t begin = (here.group - leaf_count_) * k_group_size;
    for (std::size_t i = begin; i < std::min(begin + k_group_size, segments_.size()); ++i) {
      const RayProjection on_segment = alidade::project(segments_[i], point);
      const bool later = on_segment.distance > nearest.distance ||
                         (on_segment.distance == nearest.distance && i > nearest.segment);
      if (later || std::isnan(on_segment.distance)) continue;
      nearest = {i, segments_[i].t_begin + on_segment.t, on_segment.distance};
    }
  }
  return nearest;
}

RayReach PathIndex::reach(const Bounds& box, double cutoff) const {
  // Nothing is nearest to a point of the box that is farther than what the whole box is near to. Boxes of
  // groups that are not larger than the box itself are good enough; that keeps large boxes cheap.
  const double fine_enough = diagonal_of(box);
  double reachable = cutoff;
  RayReach result{{k_infinity, -k_infinity}, {k_infinity, k_infinity}};
  const auto visit = [&](const auto& take) {
    std::size_t stack[k_stack_size];
    int count = 0;
    stack[count++] = 1;
    while (count > 0) {
      const std::size_t g = stack[--count];
      const Group& group = groups_[g];
      if (group.bounds.empty()) continue;
      const Interval between = distance_between(box, group.bounds);
      if (between.low > reachable) continue;
      if (group.diagonal <= fine_enough) {
        take(RayReach{group.t, between});
      } else if (g < leaf_count_) {
        stack[count++] = 2 * g + 1;
        stack[count++] = 2 * g;
      } else {
        const std::size_t begin = (g - leaf_count_) * k_group_size;
        for (std::size_t i = begin; i < std::min(begin + k_group_size, segments_.size()); ++i) {
          RayReach on_segment = alidade::project(segments_[i], box);
          on_segment.t = {segments_[i].t_begin + on_segment.t.low, segments_[i].t_begin + on_segment.t.high};
          take(on_segment);
        }
      }
    }
  };
  visit([&](const RayReach& part) {
    if (part.distance.high < reachable) reachable = part.distance.high;
  });
  visit([&](const RayReach& part) {
    if (part.distance.low > reachable) return;
    result.distance.low = std::min(result.distance.low, part.distance.low);
    result.t.low = std::min(result.t.low, part.t.low);
    result.t.high = std::max(result.t.high, part.t.high);
  });
  return result;
}

}  // namespace alidade
