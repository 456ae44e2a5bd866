// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "octree/distance.h"
#include "octree/targets.h"

// The straight parts of a path, and where points lie relative to them: the formulas of octree/distance.h on
// the line of a segment, between its ends.

namespace alidade {

struct Segment {
  Ray line;              ///< from the first vertex; its closed interval is [0, length]
  glm::dvec3 end{0.0};   ///< second vertex
  double t_begin = 0.0;  ///< t of the path at the first vertex

  double length() const { return line.t_max; }
};

/// Where a point lies relative to a path.
struct PathProjection {
  std::size_t segment = 0;  ///< nearest one; of equally near ones the first
  double t = 0.0;           ///< of the nearest point of the path
  double distance = std::numeric_limits<double>::quiet_NaN();
};

/// The segment from vertex i to the next.
inline Segment segment_of(const Path& path, std::size_t i) {
  const glm::dvec3 way = path.vertices[i + 1] - path.vertices[i];
  return {
      {path.vertices[i], unit_direction(way), 0.0, length_of(way)}, path.vertices[i + 1], path.vertex_t[i]};
}

inline std::vector<Segment> segments_of(const Path& path) {
  std::vector<Segment> segments;
  segments.reserve(path.vertices.size() - 1);
  for (std::size_t i = 0; i + 1 < path.vertices.size(); ++i) segments.push_back(segment_of(path, i));
  return segments;
}

/// The nearest point of a segment (t from its first vertex) and the distance to it.
inline RayProjection project(const Segment& segment, const glm::dvec3& point) {
  const RayProjection on_line = project(segment.line, point);
  if (on_line.t <= 0.0) return {0.0, distance(segment.line.origin, point)};
  if (on_line.t >= segment.length()) return {segment.length(), distance(segment.end, point)};
  return on_line;
}

/// project() for all points of a box: whichever of the three cases above may occur.
inline RayReach project(const Segment& segment, const Bounds& box) {
  const RayReach on_line = project(segment.line, box);
  RayReach reach{{0.0, segment.length()}, {std::numeric_limits<double>::infinity(), 0.0}};
  const auto may_be = [&](const Interval& case_distance) {
    reach.distance.low = std::min(reach.distance.low, case_distance.low);
    // Written so that NaN stays.
    if (!(case_distance.high <= reach.distance.high)) reach.distance.high = case_distance.high;
  };
  if (!(on_line.t.low > 0.0)) may_be(distance(segment.line.origin, box));
  if (!(on_line.t.high < segment.length())) may_be(distance(segment.end, box));
  if (!(on_line.t.high <= 0.0 || on_line.t.low >= segment.length())) may_be(on_line.distance);
  if (on_line.t.low > 0.0) reach.t.low = std::min(on_line.t.low, segment.length());
  if (on_line.t.high < segment.length()) reach.t.high = std::max(on_line.t.high, 0.0);
  return reach;
}

/// The nearest point of a path: the definition. Distance NaN if no segment's can be computed.
inline PathProjection project(std::span<const Segment> segments, const glm::dvec3& point) {
  PathProjection nearest;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const RayProjection here = project(segments[i], point);
    if (here.distance >= nearest.distance || std::isnan(here.distance)) continue;
    nearest = {i, segments[i].t_begin + here.t, here.distance};
  }
  return nearest;
}

/// The segments of a path under boxes around groups of consecutive ones, so that what is near is found
/// without testing all: trajectories have many thousand vertices.
class PathIndex {
 public:
  /// Requires a checked path. Cost: linear.
  explicit PathIndex(const Path& path);

  /// Same bits as project(segments_of(path), point). Cost: logarithmic for paths that are no tangle.
  PathProjection project(const glm::dvec3& point) const;

  /// Bounds for the points of a box on the distance to the path and on t of the nearest point of the path, as
  /// project() gives them. Segments that are farther than `cutoff` are left out; if all are, distance.low is
  /// infinite. distance.high is unused.
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
