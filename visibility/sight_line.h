// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>

#include "visibility/occluders.h"

// Whether one sees from here to there, through the points of a cloud.
//
//   const Occluders occluders(octree, {});
//   const SightEnd tree = end_on_point(occluders, id, position, eye);
//   if (std::optional<Blocker> blocker = first_blocker(occluders, sight_line({eye}, tree))) ...
//
// A line is blocked by discs whose plane it crosses, and by spheres whose middle it passes, in its closed
// interval from end to end. What an end itself lies on does not block it: discs whose middle is near it and
// whose plane passes through it (SightEnd), and spheres that it lies in.

namespace alidade {

/// One end of a sight line.
struct SightEnd {
  glm::dvec3 position{0.0};
  /// Discs with their point within own_reach (metres), or 3 of their radii if these are more, whose plane
  /// passes within own_thickness (metres) of the position are the surface that the end lies on. 0: a place in
  /// the air.
  double own_reach = 0.0, own_thickness = 0.0;
};

/// A line of sight; made by sight_line() and sight_ray().
struct SightLine {
  SightEnd from, to;                                        ///< `to` means nothing if the line has no end
  glm::dvec3 direction{0.0, 0.0, 1.0};                      ///< of length 1
  double length = std::numeric_limits<double>::infinity();  ///< metres
};

/// Errors: ends not finite. Ends at one place are a line of length 0, which nothing blocks.
SightLine sight_line(const SightEnd& from, const SightEnd& to);

/// Everything in one direction, up to a length in metres. Errors: as make_ray; length negative or NaN.
SightLine sight_ray(const SightEnd& from, const glm::dvec3& direction,
                    double length = std::numeric_limits<double>::infinity());

/// A point of the cloud as an end: on its sheet, lifted by the sheet's thickness towards the side that
/// `seen_from` is on; where the line grazes the sheet by less than 0.02 (1.1 degrees), upwards. Its own
/// surface are the discs whose planes pass within 3 thicknesses and whose points are near: within 3 of their
/// radii or, where each has its own, 4 of the widest sphere's. A point without a surface stands where it is.
/// Requires: point_id has this position.
SightEnd end_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                      const glm::dvec3& seen_from);

/// A place on or a little above the ground or a roof as an end: the surface of the nearest point, as far as
/// it passes near the place, is its own. Where no point is within the radius of the widest sphere, or the
/// nearest has no surface, a place in the air. Cost: a microsecond.
SightEnd end_near_surface(const Occluders& occluders, const glm::dvec3& position);

/// What blocks a line.
struct Blocker {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};  ///< of the point
  double distance =
      0.0;  ///< metres from the line's start to where it crosses the disc, or passes the middle of the sphere

  bool operator==(const Blocker&) const = default;
};

/// The first point that blocks, in the order of where the line passes their middles (the projection t), then
/// by point id; with a transparency of k, the one that makes the k-th separate crossing. Empty: seen.
std::optional<Blocker> first_blocker(const Occluders& occluders, const SightLine& line);

/// Many lines at once, in parallel; the same answers on any number of threads and any instruction set. Lines
/// that lie near each other should follow each other. Answers as many as lines. Cost: 0.3 to some
/// microseconds of one thread per line.
void first_blockers(const Occluders& occluders, std::span<const SightLine> lines,
                    std::span<std::optional<Blocker>> blockers);

/// Whether there is such a point, 1 or 0: faster.
void blocked(const Occluders& occluders, std::span<const SightLine> lines, std::span<std::uint8_t> answers);

}  // namespace alidade
