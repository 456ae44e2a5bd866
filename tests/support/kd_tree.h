// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade::test {

/// A balanced kd-tree with a point in every inner node, for octree/tree_query.h: nothing is stored but the
/// order of the points; boxes follow from the splits on the way down, so they are not tight.
class KdTree {
 public:
  /// A range of the points, split at its middle.
  struct Node {
    std::size_t begin = 0, end = 0;
    int axis = 0;
    Bounds bounds;
  };

  explicit KdTree(const PointCloud& cloud) : cloud_(cloud), bounds_(cloud.bounds()) {
    for (std::size_t id = 0; id < cloud.size(); ++id) ids_.push_back(id);
    split(0, ids_.size(), 0);
  }

  bool empty() const { return ids_.empty(); }
  Node root() const { return {0, ids_.size(), 0, bounds_}; }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    visit(ids_[middle(node.begin, node.end)], cloud_.world(ids_[middle(node.begin, node.end)]));
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    const std::size_t at = middle(node.begin, node.end);
    const double coordinate = cloud_.world(ids_[at])[node.axis];
    Node below{node.begin, at, (node.axis + 1) % 3, node.bounds};
    Node above{at + 1, node.end, (node.axis + 1) % 3, node.bounds};
    below.bounds.max[node.axis] = coordinate;
    above.bounds.min[node.axis] = coordinate;
    if (below.begin < below.end) visit(below);
    if (above.begin < above.end) visit(above);
  }

 private:
  static std::size_t middle(std::size_t begin, std::size_t end) { return begin + (end - begin) / 2; }

  void split(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const auto at = [&](std::size_t i) { return ids_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle(begin, end)), at(end), [&](std::uint64_t a, std::uint64_t b) {
      return cloud_.world(a)[axis] < cloud_.world(b)[axis];
    });
    split(begin, middle(begin, end), (axis + 1) % 3);
    split(middle(begin, end) + 1, end, (axis + 1) % 3);
  }

  const PointCloud& cloud_;
  Bounds bounds_;
  std::vector<std::uint64_t> ids_;
};

}  // namespace alidade::test
