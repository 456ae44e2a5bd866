// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace alidade {

/// Direction of the i-th of places that spread evenly around a middle, in turns, [0, 1): each is turned by
/// the golden angle, (3 - sqrt 5) / 2 of a turn, from the one before. Source: Vogel, A better way to
/// construct the sunflower head, 1979.
inline double golden_turns(int i) {
  constexpr double k_golden_turn = 0.38196601125010515;
  const double turns = i * k_golden_turn;
  return turns - std::floor(turns);
}

}  // namespace alidade
