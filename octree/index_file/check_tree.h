// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octree/octree.h"

// Whether the arrays of an octree that came from outside are an octree. build() makes none that is not.

namespace alidade {

/// The first thing found that is wrong.
struct TreeFault {
  enum class Array { nodes, ids, coordinates, positions, spacings, slot_spacings } array = Array::nodes;
  std::uint64_t index = 0;  ///< of the node, position or slot spacing, otherwise the point's storage index
  std::string problem;      ///< one clause: what was expected and what was found
};

/// Whether every query ends and stays inside the arrays: each node but the root is the child of exactly one
/// node before it; levels and depth stay within their limits; leaves have at most k_max_leaf_size points, lie
/// inside the point count, and have exact positions where they need them; points below low frames are
/// contiguous (Node in octree/octree.h). It checks neither the boxes nor where points lie. Requires arrays of
/// the sizes that the view gives, with a root level from 8 to 32 and at most k_max_tree_depth levels. Cost:
/// two passes over the nodes, on one thread; 6 B per node.
std::optional<TreeFault> find_broken_link(const TreeView& tree);

/// Whether every one of some ids is a row: below the point count. The fault's index is that among them. Cost:
/// linear.
std::optional<TreeFault> find_bad_id(std::span<const std::uint32_t> ids, std::uint64_t point_count);

/// Whether the answers are those of the points: every storage index is in one leaf, every id occurs once,
/// every box holds the points below it, coordinates agree with exact positions, the bounds are those of the
/// points, slots of one position have the lowest ids in the first of them, and spacings are positive and
/// equal for all points of a slot of one position. Requires that find_broken_link() and find_bad_id() find
/// nothing. Cost: one pass over all arrays, one more over points of one position for each level they take; in
/// parallel; 12 B per node and 1/4 B per point.
std::optional<TreeFault> find_misplaced_point(const TreeView& tree, const PointLayers& layers);

/// Whether every slot spacing is the greatest of the spacings below. Requires spacings, and that
/// find_broken_link() finds nothing. Cost: one pass over nodes and spacings.
std::optional<TreeFault> find_bad_slot_spacing(const TreeView& tree, const PointLayers& layers);

}  // namespace alidade
