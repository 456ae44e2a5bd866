// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/huge_memory.h"
#include "octree/octree.h"
#include "octree/tree_walk.h"

namespace alidade {

/// Surfaces and edges (surface/point_surface.h) of the points of a leaf, packed.
struct LeafSurfaces {
  std::uint32_t surfaces[k_max_leaf_size];
  std::uint8_t edges[k_max_leaf_size];
};

/// Of all points, in one of their orders.
struct SurfaceArrays {
  HugeArray<std::uint32_t> surfaces;
  HugeArray<std::uint8_t> edges;

  SurfaceArrays(std::size_t size, const ScratchFolder& scratch)
      : surfaces(size, scratch), edges(size, scratch) {}
};

/// Fits the surfaces of points that come leaf by leaf. What it returns is valid until the next call. One
/// thread each; the faster the nearer leaves follow each other.
using FitLeaf = std::function<const LeafSurfaces&(const Leaf& leaf)>;

/// The octree, which has spacings, must outlive it. unit: automatic_radius() of the octree.
FitLeaf surface_fitter(const Octree& octree, double unit);

}  // namespace alidade
