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

// Sight over the round Earth. A map is flat, so that things at the distance d are too high in it, by
// d^2 / (2 R) less the bend of light by refraction: c d^2 / (2 R). The points remain where they are; the
// line of sight is bent instead. A straight line in true space is, on the map, the parabola between the two
// ends that hangs below their chord by k s (d - s), with k = c / (2 R) and s from one end: at most k d^2 / 4.
// It is approximated by chords within k_most_sag.
// Sources: gdal_viewshed, option -cc; r.viewshed, flags -c and -r.

namespace alidade::visibility {

/// The coefficient of gdal_viewshed: light is bent by a seventh of the Earth's curvature.
constexpr double k_usual_curvature = 0.85714;
constexpr double k_most_sag = 0.005;  ///< metres; chords of light are at most 545 m long

/// The bend of lines of sight.
class SightCurve {
 public:
  /// Straight.
  SightCurve() = default;
  /// `coefficient`: 0 for a flat Earth, 1 for a round one without air, k_usual_curvature for light, less for
  /// radio. `unit`: metres of a unit of the cloud. Errors: coefficient outside of [0, 10] or not a number.
  SightCurve(double coefficient, double unit);

  double coefficient() const { return coefficient_; }
  /// How much too high things at this distance along the ground are, in units of the cloud.
  double drop(double distance) const { return per_square_ * distance * distance; }
  /// Number of chords of a line over this distance along the ground; finite.
  std::int64_t chord_count(double distance) const;
  /// The position at a share [0, 1] of the way.
  glm::dvec3 position(const glm::dvec3& from, const glm::dvec3& to, double share) const;

 private:
  double coefficient_ = 0.0;
  double per_square_ = 0.0;     ///< k above
  double longest_chord_ = 0.0;  ///< 0: no limit
};

/// A batch of lines of sight, each bent into one or more chords. Chords over land without points are left
/// out, since nothing blocks there: so lines to an observer far away cost little.
class SightBatch {
 public:
  SightBatch(const Occluders& occluders, const SightCurve& curve);

  std::size_t size() const { return begin_.size() - 1; }
  /// Chords of all lines, to which work and memory are proportional.
  std::size_t chord_count() const { return chords_.size(); }
  /// Errors: ends not finite, or so far apart that their distance is not.
  void add(const SightEnd& from, const SightEnd& to);
  void clear();

  /// Whether each line, in the order of add(), is blocked; valid until the batch changes. Crossings
  /// are counted over all chords of a line. Cost: sight_line.h's per chord; memory: 250 B per chord and line.
  std::span<const std::uint8_t> blocked();
  /// The first blocker of each line; its distance is from the line's start, along the straight
  /// line to within k_most_sag.
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
