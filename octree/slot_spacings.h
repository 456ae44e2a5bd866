// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "octree/octree.h"

namespace alidade {

/// The greatest spacings below the slots of a node, as TreeView::slot_spacings has them; 0 for empty slots.
/// slot_spacings: those of all nodes behind this one are read, among which its children are. Requires
/// spacings.
inline std::array<std::uint16_t, k_node_width> greatest_spacings(const TreeView& tree,
                                                                 const std::uint16_t* slot_spacings,
                                                                 std::uint32_t index) {
  const Node& node = tree.nodes[index];
  std::uint32_t place = node.first_point;
  std::uint64_t child = node.first_child;
  std::array<std::uint16_t, k_node_width> greatest{};
  for (int slot = 0; slot < k_node_width; ++slot) {
    const std::uint8_t kind = node.kind[slot];
    // The bits of floats that are not negative have the order of the numbers.
    if (is_inner(kind)) {
      const std::uint16_t* below = slot_spacings + k_node_width * child++;
      greatest[slot] = *std::max_element(below, below + k_node_width);
    } else if (is_leaf(kind)) {
      greatest[slot] = *std::max_element(tree.spacings + place, tree.spacings + place + kind);
      place += kind;
    }
  }
  return greatest;
}

}  // namespace alidade
