// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "octree/segment.h"

namespace alidade {

/// The segments of a path under boxes around groups of consecutive ones, so that what is near is found
/// without asking all: trajectories have many thousand vertices.
class PathIndex {
 public:
  /// Requires a checked path. Cost: linear.
  explicit PathIndex(const Path& path);

  /// Same bits as project(segments_of(path), point). Cost: logarithmic for paths that are no tangle.
  PathProjection project(const glm::dvec3& point) const;

  /// Bounds for the points of a box on the distance to the path and on t of the nearest place, as project()
  /// gives them. Segments that are farther than `cutoff` are left out; if all are, distance.low is infinite.
  /// distance.high is unused.
  RayReach reach(const Bounds& box, double cutoff) const;

 private:
  struct Group {
    Bounds bounds;
    Interval t;
    double diagonal = 0.0;
  };

  /// Group g has the children 2 g and 2 g + 1; those from leaf_count_ on have segments.
  std::vector<Group> groups_;
  std::size_t leaf_count_ = 0;
  std::vector<Segment> segments_;
};

}  // namespace alidade
