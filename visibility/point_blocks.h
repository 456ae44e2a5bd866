// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "cloud/lattice.h"
#include "octree/tree_walk.h"

// The points of a cloud in blocks of neighbours in space, for batches of lines.

namespace alidade::visibility {

/// A point of a cloud.
struct PlacedPoint {
  glm::dvec3 position{0.0};
  std::uint32_t index = 0;  ///< storage index
  std::uint64_t point_id = 0;
};

/// All leaves in the order of the octree, in blocks that end with the leaf that fills `size` points. They
/// depend on nothing but the tree and `size`. Cost and memory: linear in the leaves.
inline std::vector<std::vector<Leaf>> leaf_blocks(const TreeView& tree, std::size_t size) {
  std::vector<std::vector<Leaf>> blocks;
  std::size_t points = size;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    if (points >= size) {
      blocks.emplace_back();
      points = 0;
    }
    blocks.back().push_back(leaf);
    points += leaf.count;
  });
  return blocks;
}

/// The points of some leaves, in their order; in parallel.
inline std::vector<PlacedPoint> placed_points(const TreeView& tree, std::span<const Leaf> leaves) {
  std::vector<std::size_t> begins{0};
  for (const Leaf& leaf : leaves) begins.push_back(begins.back() + leaf.count);
  std::vector<PlacedPoint> points(begins.back());
  in_parallel(leaves.size(), 64, [&](std::size_t l) {
    const Leaf& leaf = leaves[l];
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      points[begins[l] + i] = {to_world(tree.lattice, position_of(tree, leaf, i)), leaf.first + i,
                               point_id(tree, leaf.first + i)};
    }
  });
  return points;
}

}  // namespace alidade::visibility
