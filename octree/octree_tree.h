// SPDX-License-Identifier: MIT
#pragma once

#include "octree/query.h"
#include "octree/tree_walk.h"

namespace alidade {

/// By what a tree tells its points apart.
enum class PointNaming { id, place };

/// An octree as tree_query.h walks it: inner nodes by their frames, leaves as nodes of their own.
template <PointNaming naming>
class OctreeAsTree {
 public:
  struct Node {
    Bounds bounds;
    bool inner = true;
    Frame frame{};  ///< of an inner node
    Leaf leaf{};    ///< otherwise
  };

  /// Of a layered octree only the levels 0 to max_level.
  explicit OctreeAsTree(const TreeView& view, int max_level = k_all_levels)
      : view_(view), max_level_(max_level) {}

  bool empty() const { return view_.node_count == 0; }
  Node root() const { return {.bounds = view_.bounds, .frame = root_frame(view_)}; }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.inner) return;
    for (std::uint32_t i = 0; i < node.leaf.count; ++i) {
      const std::uint32_t place = node.leaf.place + i;
      if (!visit(naming == PointNaming::place ? place : point_id(view_, place),
                 to_world(view_.lattice, position_of(view_, node.leaf, i))))
        return;
    }
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (!node.inner) return;
    const bool deeper = node.frame.depth < max_level_;
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = view_.nodes[node.frame.node].kind[slot];
      if (is_inner(kind)) {
        if (!deeper) continue;
        visit(Node{.bounds = child_bounds(view_, node.frame, slot),
                   .frame = child_frame(view_, node.frame, slot)});
      } else if (is_leaf(kind)) {
        visit(Node{.bounds = child_bounds(view_, node.frame, slot),
                   .inner = false,
                   .leaf = child_leaf(view_, node.frame, slot)});
      }
    }
  }

 private:
  const TreeView& view_;
  int max_level_;
};

using OctreeTree = OctreeAsTree<PointNaming::id>;
/// For targets that ask what is stored by place.
using OctreePlaces = OctreeAsTree<PointNaming::place>;

}  // namespace alidade
