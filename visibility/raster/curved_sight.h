// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "geo/earth.h"
#include "visibility/sight_line.h"

// Sight over the round Earth. A map is flat, so that what lies at the distance d stands too high in it, by
// d^2 / (2 R) less what refraction bends the light down: c d^2 / (2 R). The points stay where they are; the
// line of sight is bent instead. A straight line in true space is, on the map, the parabola between the two
// ends that hangs below their chord by k s (d - s), with k = c / (2 R) and s from one end: at most k d^2 / 4.
// It is followed by chords of which none is farther from it than k_most_sag.
// Sources: gdal_viewshed, option -cc; r.viewshed, flags -c and -r.

namespace alidade::visibility {

/// The coefficient of gdal_viewshed: light is bent by a seventh of the Earth's curvature.
constexpr double k_usual_curvature = 0.85714;
constexpr double k_most_sag = 0.005;  ///< metres; chords of light are at most 545 m long

/// How lines of sight are bent.
class SightCurve {
 public:
  /// Straight.
  SightCurve() = default;
  /// `coefficient`: 0 for a flat Earth, 1 for a round one without air, k_usual_curvature for light, less for
  /// radio. `unit`: metres of a unit of the cloud. Errors: coefficient outside of [0, 10] or not a number.
  SightCurve(double coefficient, double unit);

  double coefficient() const { return coefficient_; }
  /// How far too high a position at this distance along the ground lies, in units of the cloud.
  double drop(double distance) const { return per_square_ * distance * distance; }
  /// Chords that a line over this distance along the ground is made of; finite.
  std::int64_t chord_count(double distance) const;
  /// The position at a share [0, 1] of the way.
  glm::dvec3 position(const glm::dvec3& from, const glm::dvec3& to, double share) const;

 private:
  double coefficient_ = 0.0;
  double per_square_ = 0.0;     ///< k above
  double longest_chord_ = 0.0;  ///< 0: no limit
};

/// Lines of sight to be answered together, each bent into one or more chords. Chords over land where there
/// are no points are left out, since nothing blocks there: so lines to an observer far away cost little.
class SightBatch {
 public:
  SightBatch(const Occluders& occluders, const SightCurve& curve);

  std::size_t size() const { return begin_.size() - 1; }
  /// Chords of all lines, what the work and memory go with.
  std::size_t chord_count() const { return chords_.size(); }
  /// Errors: ends not finite, or so far apart that their distance is not.
  void add(const SightEnd& from, const SightEnd& to);
  void clear();

  /// Whether each line, in the order of add(), is blocked; as long as the batch stays unchanged. Crossings
  /// are counted over all chords of a line. Cost: sight_line.h's per chord; memory: 250 B per chord and line.
  std::span<const std::uint8_t> blocked();
  /// The first blocker of each line; its distance is from the line's start, along the straight line to within
  /// the sag.
  std::span<const std::optional<Blocker>> first_blockers();

 private:
  Occluders occluders_;
  SightCurve curve_;
  Bounds reach_;              ///< over which anything can block
  bool all_straight_ = true;  ///< every line is one chord
  std::vector<SightLine> chords_;
  std::vector<double> chord_starts_;   ///< distance of each chord from its line's start
  std::vector<std::size_t> begin_{0};  ///< first chord of each line, and the end
  std::vector<std::uint8_t> chord_answers_;
  std::vector<std::uint8_t> answers_;
  std::vector<std::optional<Blocker>> blockers_;
};

}  // namespace alidade::visibility
