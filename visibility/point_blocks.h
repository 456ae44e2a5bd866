// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "octree/tree_walk.h"

namespace alidade {

/// A point of a cloud.
struct PlacedPoint {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
};

/// Calls visit(points) with some `size` points at a time until every point was there once: neighbours in
/// space mostly come together, as batches of lines want it. Cost: linear.
template <class Visit>
void for_each_point_block(const TreeView& tree, std::size_t size, const Visit& visit) {
  std::vector<PlacedPoint> points;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      points.push_back({point_id(tree, leaf.place + i), to_world(tree.lattice, position_of(tree, leaf, i))});
    if (points.size() < size) return;
    visit(std::span<const PlacedPoint>(points));
    points.clear();
  });
  if (!points.empty()) visit(std::span<const PlacedPoint>(points));
}

}  // namespace alidade
