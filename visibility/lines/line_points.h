// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "visibility/lines/line_curve.h"

// The points beside a line, measured from its middle: what may block and does not lie behind an end, in an
// end margin, or within SightEnd::own_reach of an end.

namespace alidade {

struct LinePoint {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  double t = 0.0;         ///< of the nearest place of the line, metres along the chord
  double distance = 0.0;  ///< to it, metres
};

/// The nearest point; of equally near ones the one with the lowest id. Empty: there is none.
std::optional<LinePoint> nearest_point(const Occluders& occluders, const LineCurve& curve);

/// All points of the curve's zone, by t, then by id. Cost: a ray's query, and their number.
std::vector<LinePoint> points_in_zone(const Occluders& occluders, const LineCurve& curve);

}  // namespace alidade
