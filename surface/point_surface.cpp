// SPDX-License-Identifier: MIT
#include "surface/point_surface.h"

#include <glm/vec2.hpp>
#include <memory>

#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/local_plane.h"
#include "surface/packed_surface.h"
#include "surface/surface_fitter.h"

namespace alidade {

PointSurface unpack_surface(std::uint32_t packed, double unit) {
  using namespace packed_surface;
  if ((packed & k_exists) == 0) return {};
  const double height = unit * k_lengths[packed >> k_height & k_length_mask];
  const glm::uvec2 normal = {packed >> k_first_side & k_side_mask, packed >> k_second_side & k_side_mask};
  return {true, unpack_normal(normal, k_side_steps), (packed & k_below) != 0 ? -height : height,
          unit * k_lengths[packed & k_length_mask]};
}

SheetEdge unpack_edge(std::uint8_t packed, const glm::dvec3& normal) {
  const int level = packed / packed_surface::k_edge_directions;
  if (level == 0) return {};
  const PlaneAxes axes = axes_across(normal);
  const glm::dvec2& direction = packed_surface::edge_directions()[packed % packed_surface::k_edge_directions];
  return {direction.x * axes.first + direction.y * axes.second,
          packed_surface::k_edge_gap + packed_surface::k_edge_step * (level - 1)};
}

Octree with_surfaces(const Octree& octree, const Progress& progress) {
  if (octree.size() == 0 || octree.layers().surfaces) return octree;
  const TreeView& tree = octree.view();
  const auto made = std::make_shared<SurfaceArrays>(tree.point_count, octree.scratch());
  PointLayers layers = octree.layers();
  layers.surface_unit = automatic_radius(octree);
  for_each_leaf_in_parallel(tree, progress, [&] {
    return [&, fit = surface_fitter(octree, layers.surface_unit)](const Leaf& leaf) {
      const LeafSurfaces& fitted = fit(leaf);
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const std::uint64_t id = point_id(tree, leaf.first + i);
        made->surfaces[id] = fitted.surfaces[i];
        made->edges[id] = fitted.edges[i];
      }
    };
  });
  layers.surfaces = made->surfaces.data();
  layers.sheet_edges = made->edges.data();
  return octree.with_layers(layers, made);
}

PointSurface surface_of(const PointLayers& layers, std::uint64_t point_id) {
  return unpack_surface(layers.surfaces[point_id], layers.surface_unit);
}

}  // namespace alidade
