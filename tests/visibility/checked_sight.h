// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "geo/earth.h"
#include "visibility/horizon/horizon.h"
#include "visibility/sight_line.h"

// Answers about sight that are checked against plainer ones.

namespace alidade::test {

using namespace visibility;

/// Of one line; both ways to get it must agree.
inline std::optional<Blocker> blocker_of(const Occluders& occluders, const SightLine& line) {
  const std::optional<Blocker> blocker = first_blocker(occluders, line);
  std::uint8_t answer = 2;
  blocked(occluders, {&line, 1}, {&answer, 1});
  EXPECT_EQ(answer, blocker ? 1 : 0);
  return blocker;
}

/// Expects that a direction of a horizon of this length (metres) with a resolution of a quarter degree has
/// the highest blocked line and what blocks it.
inline void expect_highest_blocked(const HorizonDirection& direction, const Occluders& occluders,
                                   const SightEnd& eye,
                                   double length = std::numeric_limits<double>::infinity()) {
  constexpr int k_steps = 360;  // of a quarter degree, up and down
  std::vector<SightLine> lines;
  for (int step = k_steps; step >= -k_steps; --step)
    lines.push_back(sight_ray(eye, geo::compass_direction(direction.azimuth, 90.0 * step / k_steps), length));
  std::vector<std::uint8_t> answers(lines.size());
  blocked(occluders, lines, answers);
  const auto first = std::ranges::find(answers, std::uint8_t{1});
  ASSERT_EQ(direction.elevation.has_value(), first != answers.end()) << direction.azimuth;
  if (!direction.elevation) return;
  const auto number = first - answers.begin();
  EXPECT_EQ(*direction.elevation, 90.0 * static_cast<double>(k_steps - number) / k_steps)
      << direction.azimuth;
  EXPECT_EQ(direction.blocker, first_blocker(occluders, lines[static_cast<std::size_t>(number)]));
}

}  // namespace alidade::test
