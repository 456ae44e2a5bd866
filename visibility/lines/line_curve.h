// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "visibility/sight_line.h"

namespace alidade::visibility {

/// Options of all lines of a task.
struct LineOptions {
  /// Length at either end of a line that is not examined, since masts and tripods were scanned, too. Metres.
  /// If it is above 0, it replaces the surface that an end lies on: SightEnd::own_reach does not apply then.
  double end_margin = 0.0;
  /// A line sinks below the chord between its ends by t (length - t) / (2 radius), which has the same effect
  /// as ground that rises. Metres; infinite: straight. For radio 4/3 of the Earth's radius, which includes
  /// refraction by the air. Source: ITU-R P.310, "effective radius of the Earth".
  double earth_radius = std::numeric_limits<double>::infinity();
};

/// A line beside the middle one.
struct TubePosition {
  double share = 0.0;  ///< of the zone's radius: 0 the middle line, 1 the rim
  double turns = 0.0;  ///< direction around the line, in whole turns
};

/// The line between two ends, and the lines around it from end to end that fill a zone, whose radius t
/// metres from the first end is 2 middle_radius sqrt(t (length - t)) / length: an ellipsoid (if the
/// line is bent, one that sags).
class LineCurve {
 public:
  /// Errors: ends not finite.
  LineCurve(const SightEnd& from, const SightEnd& to, const LineOptions& options, double middle_radius = 0.0);

  const SightEnd& from() const { return from_; }
  const SightEnd& to() const { return to_; }
  double length() const { return length_; }  ///< of the chord, metres
  /// The part that is examined, metres along the chord; nothing if begin >= end.
  double begin() const { return begin_; }
  double end() const { return end_; }

  double zone_radius(double t) const;
  /// Requires t in [0, length].
  glm::dvec3 position(double t, const TubePosition& tube = {}) const;
  /// Where the straight pieces of a line meet, metres along the chord: begin, end and, if it is not straight,
  /// what lies between; empty if nothing is examined.
  std::vector<double> joints(const TubePosition& tube = {}) const;

 private:
  SightEnd from_, to_;
  glm::dvec3 along_{0.0}, across_{0.0}, up_{0.0};  ///< of length 1, at right angles
  double length_ = 0.0, begin_ = 0.0, end_ = 0.0, earth_radius_ = 0.0, middle_radius_ = 0.0;
};

/// One of the lines of a curve. The curve must outlive it.
struct CurveLine {
  const LineCurve* curve;
  TubePosition tube{};
};

/// What blocks a line first and last.
struct CurveCrossings {
  Blocker first;        ///< its distance is metres along the chord
  double last_t = 0.0;  ///< the first crossing of the last piece that is blocked, metres along the chord
};

/// The crossings of many lines, in parallel, one result per line; empty: free all along. What ends lie on
/// does not block, as with sight lines. A bent line is blocked if one of its 24 pieces is, so crossings
/// (OccluderOptions::transparency) are counted in each piece by itself.
std::vector<std::optional<CurveCrossings>> crossings(const Occluders& occluders,
                                                     std::span<const CurveLine> lines);

// The points beside a line, measured from its middle: what may block and does not lie behind an end, in an
// end margin, or within SightEnd::own_reach of an end.

struct LinePoint {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  double t = 0.0;         ///< where the line is nearest to it, metres along the chord
  double distance = 0.0;  ///< to the line there, metres
};

/// The nearest point; of equally near ones the one with the lowest id. Empty if none lies beside the line.
std::optional<LinePoint> nearest_point(const Occluders& occluders, const LineCurve& curve);

/// All points of the curve's zone, by t, then by id. Cost: a ray's query, and their number.
std::vector<LinePoint> points_in_zone(const Occluders& occluders, const LineCurve& curve);

}  // namespace alidade::visibility
