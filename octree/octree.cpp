// SPDX-License-Identifier: MIT
#include "octree/octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "octree/tree_walk.h"

namespace alidade {
namespace {

// Files may be damaged: impossible nodes are left out.
bool is_possible(const TreeView& tree, const Frame& frame) {
  return frame.node < tree.node_count && frame.level >= k_min_frame_level;
}

/// Whether all points below a node are at one position, as far as the node itself shows it.
bool is_one_position(const Node& node, int level) {
  if (level != k_min_frame_level) return false;
  for (int slot = 1; slot < k_node_width; ++slot) {
    if (node.kind[slot] == 0) continue;
    for (int axis = 0; axis < 3; ++axis)
      if (node.low[axis][slot] != node.low[axis][0] || node.high[axis][slot] != node.high[axis][0])
        return false;
  }
  return true;
}

/// Nodes from one on, up to `most` + 1 of them, those of a single position counted once.
int count_nodes(const TreeView& tree, const Frame& top, int most) {
  int count = 0;
  std::vector<Frame> waiting{top};
  while (!waiting.empty() && count <= most) {
    ++count;
    const Frame frame = waiting.back();
    waiting.pop_back();
    const Node& node = tree.nodes[frame.node];
    if (is_one_position(node, frame.level)) continue;
    for (unsigned inner = inner_slots(node); inner != 0; inner &= inner - 1) {
      const Frame child = child_frame(tree, frame, std::countr_zero(inner));
      if (is_possible(tree, child)) waiting.push_back(child);
    }
  }
  return count;
}

/// The inner child beside which there are only a few nodes.
std::optional<Frame> only_large_child(const TreeView& tree, const Frame& frame) {
  constexpr int k_few_nodes = 8;
  std::optional<Frame> large;
  int others = 0;
  for (unsigned inner = inner_slots(tree.nodes[frame.node]); inner != 0; inner &= inner - 1) {
    const Frame child = child_frame(tree, frame, std::countr_zero(inner));
    if (!is_possible(tree, child)) continue;
    const int count = count_nodes(tree, child, k_few_nodes);
    if (count <= k_few_nodes) {
      others += count;
    } else if (large) {
      return std::nullopt;
    } else {
      large = child;
    }
  }
  return others <= k_few_nodes ? large : std::nullopt;
}

Frame site_of(const TreeView& tree) {
  // In smaller frames floats lose less than a lattice step; and a site not much smaller gains nothing.
  constexpr int k_exact_level = 20, k_least_drop = 4;
  const Frame root = root_frame(tree);
  if (tree.node_count == 0 || tree.root_level <= k_exact_level) return root;
  Frame site = root;
  while (site.depth < k_max_tree_depth) {
    const std::optional<Frame> child = only_large_child(tree, site);
    if (!child) break;
    site = *child;
  }
  return site.level + k_least_drop <= root.level ? site : root;
}

}  // namespace

TreeExtent extent_of(const TreeView& tree) {
  TreeExtent extent;
  const glm::dvec3 corner = to_world(tree.lattice, tree.base), size = tree.bounds.size();
  for (int axis = 0; axis < 3; ++axis) {
    extent.corner[axis] = corner[axis];
    extent.low[axis] = tree.bounds.min[axis];
    extent.high[axis] = tree.bounds.max[axis];
    extent.scale[axis] = static_cast<float>(tree.lattice.scale[axis]);
    extent.widest_scale = std::max(extent.widest_scale, tree.lattice.scale[axis]);
    // Positions are sums of the lattice's offset and a product that may be as large.
    extent.largest_coordinate =
        std::max(extent.largest_coordinate,
                 std::fabs(tree.lattice.offset[axis]) +
                     std::max(std::fabs(tree.bounds.min[axis]), std::fabs(tree.bounds.max[axis])));
  }
  extent.frame_width = std::ldexp(extent.widest_scale, tree.root_level);
  extent.size = size.x + size.y + size.z;
  const Frame site = site_of(tree);
  extent.site_corner = site.corner;
  extent.site_level = site.level;
  extent.site_width = std::ldexp(extent.widest_scale, site.level);
  return extent;
}

std::size_t Octree::memory() const {
  const std::size_t per_point = 3 * sizeof(std::uint16_t) + (view_.ids ? sizeof(std::uint32_t) : 0);
  const std::size_t spacings = layers_.spacings ? view_.point_count + k_node_width * view_.node_count : 0;
  const std::size_t surface_bytes = layers_.surfaces ? sizeof(std::uint32_t) + sizeof(std::uint8_t) : 0;
  return view_.node_count * sizeof(Node) + view_.point_count * (per_point + surface_bytes) +
         view_.exact_count() * sizeof(LatticePosition) + spacings * sizeof(std::uint16_t);
}

}  // namespace alidade
