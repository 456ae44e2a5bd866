// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "base/progress.h"
#include "octree/octree.h"

// What blocks sight. A point of a surface is a disc: it blocks a line that crosses the plane of its sheet
// (octree/point_surface.h) within a radius of the point. So a surface is as thick as it is, and lines that
// graze flat ground pass over it; spheres would make every surface thicker by their radius. A point without
// a surface (foliage, wires) is a sphere, which blocks a line that passes it within a radius. Discs that
// would reach beyond the edge of their sheet (octree/point_surface.h) are cut off there.

namespace alidade {

enum class OccluderShape {
  automatic,  ///< discs where there is a surface, spheres elsewhere
  disc,       ///< points without a surface do not block
  sphere,     ///< of all points
};

struct OccluderOptions {
  OccluderShape shape = OccluderShape::automatic;
  /// Metres, of all points, > 0. Empty: each point has its own, by its spacing, the distance to its 8th
  /// neighbour: 0.92 of it for a disc, which leaves 0.1 % of a surface open, at most 16 times what the
  /// renderer's automatic radius would be; 0.35 of it for a sphere among discs, 0.5 where all are spheres, at
  /// most that automatic radius. Given and widest discs are not cut off at edges.
  std::optional<double> radius{};
  /// So many separate crossings block, >= 1: 1 for solid things, more to see through foliage. Crossings
  /// within a point's diameter of the first of them are one.
  int transparency = 1;
  /// Points that may block; empty: all. Must answer the same for the same point, from many threads at once.
  std::function<bool(std::uint64_t point_id)> counts{};
};

/// The cloud as what blocks sight. Safe to use from many threads.
class Occluders {
 public:
  /// Measures spacings (of 8 neighbours) and fits surfaces where the octree lacks them and they are needed.
  /// `progress` is in points, the spacings' first, then the surfaces'. Errors: radius or transparency out of
  /// range. Memory: 7 B per point. Cost: 2 to 5 microseconds of one thread per point, in parallel; nothing
  /// for an octree that has them.
  Occluders(const Octree& octree, const OccluderOptions& options, const Progress& progress = {});

  /// With what was measured.
  const Octree& octree() const { return octree_; }
  const OccluderOptions& options() const { return options_; }
  /// No disc or sphere is wider. Metres.
  double largest_radius() const { return largest_radius_; }
  /// No sphere is wider, metres.
  double largest_sphere() const { return largest_sphere_; }
  bool has_surfaces() const { return options_.shape != OccluderShape::sphere; }

 private:
  Octree octree_;
  OccluderOptions options_;
  double largest_radius_ = 0.0, largest_sphere_ = 0.0;
};

}  // namespace alidade
