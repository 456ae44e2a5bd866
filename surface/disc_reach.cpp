// SPDX-License-Identifier: MIT
#include "surface/disc_reach.h"

#include <algorithm>

#include "base/parallel.h"
#include "surface/simd/leaf_reaches.h"

namespace alidade {

HugeArray<std::uint16_t> slot_reaches(const Octree& octree, const SurfaceView& view) {
  const TreeView& tree = view.tree;
  constexpr std::size_t k_in_node = 3 * k_node_width;
  HugeArray<std::uint16_t> made(k_in_node * tree.node_count, octree.scratch());
  const auto leaf_reaches = simd::leaf_reaches(octree.instruction_set());
  constexpr std::size_t k_grain = 256;
  in_blocks(tree.node_count, k_grain, [&](std::size_t first, std::size_t end) {
    for (std::size_t node = first; node < end; ++node)
      leaf_reaches(view, tree.nodes[node], made.data() + k_in_node * node);
  });
  // Children are behind their parents. Bits of floats that are not negative have the order of the numbers.
  for (std::size_t index = tree.node_count; index-- > 0;) {
    const Node& node = tree.nodes[index];
    const std::uint16_t* below = made.data() + k_in_node * node.first_child;
    for (int slot = 0; slot < k_node_width; ++slot) {
      if (!is_inner(node.kind[slot])) continue;
      for (int axis = 0; axis < 3; ++axis, below += k_node_width)
        made[k_in_node * index + k_node_width * axis + slot] = *std::max_element(below, below + k_node_width);
    }
  }
  return made;
}

}  // namespace alidade
