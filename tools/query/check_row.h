// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "tools/query/target_kind.h"
#include "tools/query/text_line.h"

namespace alidade {

/// Errors: the value breaks the rule of its column. `found` is how it is written, `offset` where.
void check_value(const TextLine& line, std::size_t offset, const TargetColumn& column, double value,
                 std::string_view found);

/// Errors, once all values are good: a required one was not given (NaN), a direction has length zero.
/// offsets: where in the line each column's value stands.
void check_row(const TextLine& line, const TargetKind& kind, std::span<const double> row,
               std::span<const std::size_t> offsets);

}  // namespace alidade
