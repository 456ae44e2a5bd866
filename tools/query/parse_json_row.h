// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "tools/query/target_kind.h"
#include "tools/query/text_line.h"

namespace alidade {

/// Reads a line of JSON into `row`, which holds one value per column of the kind; NaN for those that are not
/// given. The line is an object whose keys are columns ("ox": 1) or vectors ("origin": [1, 2, 3]) of the
/// kind, or an array in the kind's order. Values are numbers, "inf" or "-inf"; null counts as not given.
/// Errors: no JSON (nested at most 64 deep, no key twice); an unknown key; a value given twice; one that is
/// no number or breaks its column's rule; see check_row().
void parse_json_row(const TextLine& line, const TargetKind& kind, std::span<double> row);

}  // namespace alidade
