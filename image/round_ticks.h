// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "image/point_color.h"

namespace alidade {

/// A value on a scale and how it is written.
struct RoundTick {
  double value = 0.0;
  std::string label;
};

/// The multiples of 1, 2 or 5 times a power of ten within a range (both ends included), of the finest such
/// step that gives at most `most` of them; all labels have as many decimals as the step needs. A range of one
/// value, or one too narrow for its digits, gives just its ends. Requires low <= high, magnitudes up to
/// k_largest_value, most >= 2.
std::vector<RoundTick> round_ticks(const ValueRange& range, int most);

}  // namespace alidade
