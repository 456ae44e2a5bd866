// SPDX-License-Identifier: MIT
#include "visibility/raster/curved_sight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "base/error.h"

namespace alidade::visibility {
namespace {

/// Along the ground.
double distance_between(const glm::dvec3& from, const glm::dvec3& to) {
  return glm::length(glm::dvec2(to) - glm::dvec2(from));
}

/// Part of the way from one position to another, as shares of it.
struct Stretch {
  double begin = 0.0, end = 1.0;
};

/// The part that lies over an area; it ends before it begins if the line passes beside the area.
Stretch stretch_over(const Bounds& area, const glm::dvec3& from, const glm::dvec3& to) {
  constexpr Stretch k_none{1.0, 0.0};
  Stretch stretch;
  for (int axis = 0; axis < 2; ++axis) {
    const double way = to[axis] - from[axis];
    if (way == 0.0) {
      if (from[axis] < area.min[axis] || from[axis] > area.max[axis]) return k_none;
      continue;
    }
    const double one = (area.min[axis] - from[axis]) / way, other = (area.max[axis] - from[axis]) / way;
    stretch.begin = std::max(stretch.begin, std::min(one, other));
    stretch.end = std::min(stretch.end, std::max(one, other));
  }
  return stretch;
}

/// Chords of a line: the first, and the one after the last.
struct ChordRange {
  std::int64_t begin = 0, end = 0;
};

/// Those of `count` chords that may lie over a stretch of the line; each extends
/// beyond its ends by `overlap`.
ChordRange chords_over(const Stretch& stretch, std::int64_t count, double overlap) {
  if (!(stretch.begin <= stretch.end)) return {};
  const auto chords = static_cast<double>(count);
  const auto clamped = [chords](double chord) { return std::clamp(chord, 0.0, chords); };
  // One more at either end, for the rounding of the shares.
  return {static_cast<std::int64_t>(clamped(std::floor((stretch.begin - overlap) * chords) - 1.0)),
          static_cast<std::int64_t>(clamped(std::ceil((stretch.end + overlap) * chords) + 1.0))};
}

}  // namespace

SightCurve::SightCurve(double coefficient, double unit) : coefficient_(coefficient) {
  constexpr double k_most = 10.0;
  check_that(coefficient >= 0.0 && coefficient <= k_most, "curvature coefficient out of range",
             "0 (flat) to 10", fmt::format("{}", coefficient));
  if (coefficient == 0.0) return;
  per_square_ = coefficient * unit / (2.0 * geo::k_earth_radius);
  longest_chord_ = std::sqrt(4.0 * (k_most_sag / unit) / per_square_);
}

std::int64_t SightCurve::chord_count(double distance) const {
  // Shares of more chords would not differ any more.
  constexpr double k_most = 1e15;
  if (longest_chord_ == 0.0) return 1;
  return static_cast<std::int64_t>(std::clamp(std::ceil(distance / longest_chord_), 1.0, k_most));
}

glm::dvec3 SightCurve::position(const glm::dvec3& from, const glm::dvec3& to, double share) const {
  glm::dvec3 position = from + share * (to - from);
  position.z -= drop(distance_between(from, to)) * share * (1.0 - share);
  return position;
}

SightBatch::SightBatch(const Occluders& occluders, const SightCurve& curve)
    : occluders_(occluders), curve_(curve), reach_(occluders.octree().bounds()) {
  // A line is blocked within a point's radius of the point.
  reach_.min -= occluders.largest_radius();
  reach_.max += occluders.largest_radius();
  if (const auto& mesh = occluders.options().mesh) reach_.grow(mesh->bounds());
  if (const auto& terrain = occluders.options().terrain) reach_.grow(terrain->bounds());
}

void SightBatch::add(const SightEnd& from, const SightEnd& to) {
  const double length = glm::length(to.position - from.position);
  if (!std::isfinite(length)) throw Error({.problem = "an end of a line of sight is not finite"});
  const std::int64_t count = curve_.chord_count(distance_between(from.position, to.position));
  // A sphere that a joint lies in would block neither chord: they overlap by more than it is wide.
  const double overlap = 2.0 * std::max(occluders_.typical_radius(), 0.0) / length;
  const ChordRange needed =
      count == 1 ? ChordRange{0, 1}
                 : chords_over(stretch_over(reach_, from.position, to.position), count, overlap);
  const auto chords = static_cast<double>(count);
  for (std::int64_t i = needed.begin; i < needed.end; ++i) {
    const double begin = std::max(0.0, static_cast<double>(i) / chords - overlap),
                 end = std::min(1.0, static_cast<double>(i + 1) / chords + overlap);
    const SightEnd chord_from = i == 0 ? from : chord_end(curve_.position(from.position, to.position, begin));
    const SightEnd chord_to =
        i + 1 == count ? to : chord_end(curve_.position(from.position, to.position, end));
    chords_.push_back(sight_line(chord_from, chord_to));
    chord_starts_.push_back(i == 0 ? 0.0 : begin * length);
  }
  all_straight_ = all_straight_ && count == 1;
  begin_.push_back(chords_.size());
}

void SightBatch::clear() {
  chords_.clear();
  chord_starts_.clear();
  begin_.resize(1);
  all_straight_ = true;
}

std::span<const std::uint8_t> SightBatch::blocked() {
  answers_.resize(size());
  if (all_straight_) {
    visibility::blocked(occluders_, chords_, answers_);
  } else if (occluders_.options().transparency > 1) {
    std::ranges::transform(first_blockers(), answers_.begin(),
                           [](const std::optional<Blocker>& blocker) { return blocker ? 1 : 0; });
  } else {
    chord_answers_.resize(chords_.size());
    visibility::blocked(occluders_, chords_, chord_answers_);
    for (std::size_t line = 0; line < size(); ++line) {
      const auto all = std::span(chord_answers_).subspan(begin_[line], begin_[line + 1] - begin_[line]);
      answers_[line] = std::ranges::any_of(all, [](std::uint8_t answer) { return answer != 0; });
    }
  }
  return answers_;
}

std::span<const std::optional<Blocker>> SightBatch::first_blockers() {
  blockers_.assign(size(), std::nullopt);
  if (all_straight_)
    visibility::first_blockers(occluders_, chords_, blockers_);
  else
    visibility::first_blockers(occluders_, ChordLines{chords_, chord_starts_, begin_}, blockers_);
  return blockers_;
}

}  // namespace alidade::visibility
