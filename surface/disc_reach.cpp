// SPDX-License-Identifier: MIT
#include "surface/disc_reach.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

/// Widened to how far the point at a storage index reaches.
void grow(const SurfaceView& view, std::uint32_t index, glm::dvec3& reach) {
  const double spacing = spacing_at(view.layers, index);
  const PointSurface surface = unpack_surface(view.stored_surfaces[index], view.layers.surface_unit);
  if (!surface.exists || std::isinf(spacing)) {
    reach = glm::max(reach, glm::dvec3(surface.exists ? spacing : k_reach_of_lone * spacing));
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double along = surface.normal[axis];
    const double across = std::sqrt(std::max(0.0, 1.0 - along * along));
    reach[axis] =
        std::max(reach[axis], k_disc_spacings * spacing * across + std::fabs(surface.height * along));
  }
}

}  // namespace

HugeArray<std::uint16_t> slot_reaches(const SurfaceView& view, const ScratchFolder& scratch) {
  const TreeView& tree = view.tree;
  HugeArray<std::uint16_t> made(std::size_t{3} * k_node_width * tree.node_count, scratch);
  const auto row = [&](std::size_t node, int axis) { return made.data() + k_node_width * (3 * node + axis); };
  constexpr std::size_t k_grain = 256;
  in_blocks(tree.node_count, k_grain, [&](std::size_t first, std::size_t end) {
    for (std::size_t index = first; index < end; ++index) {
      const Node& node = tree.nodes[index];
      std::uint32_t point = node.first_point;
      for (int slot = 0; slot < k_node_width; ++slot) {
        const std::uint32_t count = is_leaf(node.kind[slot]) ? node.kind[slot] : 0;
        glm::dvec3 reach(0.0);
        if (view.fitter != nullptr) {
          reach = glm::dvec3(k_disc_spacings *
                             spacing_of(view.layers.slot_spacings[k_node_width * index + slot]));
        } else {
          for (std::uint32_t i = 0; i < count; ++i) grow(view, point + i, reach);
        }
        point += count;
        for (int axis = 0; axis < 3; ++axis) row(index, axis)[slot] = spacing_bits(reach[axis]);
      }
    }
  });
  if (view.fitter != nullptr) return made;
  // Children are behind their parents. The bits of floats that are not negative have the order of the numbers.
  for (std::size_t index = tree.node_count; index-- > 0;) {
    const Node& node = tree.nodes[index];
    std::size_t child = node.first_child;
    for (int slot = 0; slot < k_node_width; ++slot) {
      if (!is_inner(node.kind[slot])) continue;
      for (int axis = 0; axis < 3; ++axis)
        row(index, axis)[slot] = *std::max_element(row(child, axis), row(child, axis) + k_node_width);
      ++child;
    }
  }
  return made;
}

}  // namespace alidade
