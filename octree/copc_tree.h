// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "base/bounds.h"
#include "octree/boxed_points.h"
#include "octree/copc_cache.h"

namespace alidade {

/// A COPC file as tree_query.h walks it: an octree on disk, asked where it lies. Its nodes are
/// - cubes: nodes of the file's hierarchy, whose children are cubes and their own points;
/// - own points of a cube, whose chunk is decoded when this node's children are asked for;
/// - boxes of these points, and blocks of some points.
/// point_id is the row in the order of the file, as in the cloud that read_cloud() gives.
///
///   CopcFile file(InputFile("big.copc.laz"));
///   CopcCache cache(file, {});
///   RayTarget target(ray, query);
///   Nearest<RayTarget> neighbors(target, 8);
///   tree_query(CopcTree(cache), target, neighbors);
///
/// Answers equal those of the loaded cloud bit for bit, provided that each point lies in the cube of its node
/// as COPC demands. What is decoded is held to it; a cube that is pruned is believed.
class CopcTree {
 public:
  enum class Kind : std::uint8_t { cube, own_points, box };

  struct Node {
    Bounds bounds;
    Kind kind = Kind::cube;
    std::int8_t level = 0;     ///< of a box
    std::uint32_t number = 0;  ///< of the node in the hierarchy
    std::size_t box = 0;
    std::shared_ptr<const BoxedPoints> points{};  ///< of a box
  };

  /// The cache must outlive the tree.
  explicit CopcTree(const CopcCache& cache) : cache_(cache), hierarchy_(cache.file().hierarchy()) {}

  bool empty() const { return hierarchy_.nodes.empty(); }
  Node root() const { return cube(0); }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.kind != Kind::box || node.level > 0) return;
    const std::uint64_t first_row = hierarchy_.nodes[node.number].first_row;
    const std::size_t first = node.box * BoxedPoints::k_block_points;
    const std::size_t last = std::min(first + BoxedPoints::k_block_points, node.points->size());
    for (std::size_t i = first; i < last; ++i) {
      if (!visit(first_row + node.points->rows()[i], to_world(lattice(), node.points->positions()[i])))
        return;
    }
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (node.kind == Kind::cube) {
      const CopcNode& cube_node = hierarchy_.nodes[node.number];
      if (cube_node.chunk.point_count > 0) {
        visit(Node{.bounds = node.bounds, .kind = Kind::own_points, .number = node.number});
      }
      for (const std::uint32_t child : hierarchy_.children_of(cube_node)) visit(cube(child));
    } else if (node.kind == Kind::own_points) {
      const std::shared_ptr<const BoxedPoints> points = cache_.points(node.number);
      const int top = points->levels() - 1;
      if (top >= 0) visit_boxes(node.number, points, top, 0, points->boxes(top).size(), visit);
    } else if (node.level > 0) {
      const int below = node.level - 1;
      const std::size_t first = node.box * BoxedPoints::k_fan_out;
      const std::size_t last = std::min(first + BoxedPoints::k_fan_out, node.points->boxes(below).size());
      visit_boxes(node.number, node.points, below, first, last, visit);
    }
  }

 private:
  const Lattice& lattice() const { return cache_.file().header().lattice; }

  Node cube(std::uint32_t number) const {
    return {.bounds = cache_.file().bounds(hierarchy_.nodes[number]), .kind = Kind::cube, .number = number};
  }

  template <class Visit>
  void visit_boxes(std::uint32_t number, const std::shared_ptr<const BoxedPoints>& points, int level,
                   std::size_t first, std::size_t last, const Visit& visit) const {
    for (std::size_t i = first; i < last; ++i) {
      const BoxedPoints::Box& box = points->boxes(level)[i];
      visit(Node{.bounds = {to_world(lattice(), box.min), to_world(lattice(), box.max)},
                 .kind = Kind::box,
                 .level = static_cast<std::int8_t>(level),
                 .number = number,
                 .box = i,
                 .points = points});
    }
  }

  const CopcCache& cache_;
  const CopcHierarchy& hierarchy_;
};

}  // namespace alidade
