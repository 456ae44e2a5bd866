// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "octree/tree_walk.h"

namespace alidade {

/// A point of a cloud.
struct PlacedPoint {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
};

/// The points of a cloud in blocks of neighbours in space, as batches of lines want them: each point is in
/// one of them. The same blocks for the same tree.
class PointBlocks {
 public:
  /// Blocks of `size` points and at most a leaf more. The tree must outlive this. Cost: linear in the leaves;
  /// so is the memory.
  PointBlocks(const TreeView& tree, std::size_t size) : tree_(tree) {
    std::size_t points = size;
    for_each_leaf(tree, [&](const Leaf& leaf) {
      if (points >= size) {
        blocks_.emplace_back();
        points = 0;
      }
      blocks_.back().push_back(leaf);
      points += leaf.count;
    });
  }

  std::size_t count() const { return blocks_.size(); }

  std::vector<PlacedPoint> block(std::size_t number) const {
    std::vector<PlacedPoint> points;
    for (const Leaf& leaf : blocks_[number]) {
      for (std::uint32_t i = 0; i < leaf.count; ++i)
        points.push_back(
            {point_id(tree_, leaf.place + i), to_world(tree_.lattice, position_of(tree_, leaf, i))});
    }
    return points;
  }

 private:
  const TreeView& tree_;
  std::vector<std::vector<Leaf>> blocks_;
};

}  // namespace alidade
