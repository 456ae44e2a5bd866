// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/report/page_json.h"

// How a comparison came to its figures: what was left out, how FLIP looked, what was fitted and found. For
// those who read a result without the command that made it.

namespace alidade {

struct HowLine {
  std::string name, text;
};

/// A line for everything that was asked for or found; of colours at least how FLIP was computed.
std::vector<HowLine> how_lines(const Comparison& comparison);

/// The options alone, for programs: those that were given, and pixels_per_degree and tone_mapper of colours.
Json how_json(const Comparison& comparison);

}  // namespace alidade
