// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tools/query/target_kind.h"
#include "tools/query/text_line.h"

namespace alidade {

/// The header of a CSV: for every cell the kind's column. Errors: a name that is unknown or stands twice, a
/// required column that is missing, no names at all.
std::vector<std::size_t> read_header(const TextLine& line, const TargetKind& kind);

/// The columns of values without a header, as many as there are: the kind's own order. Errors: too few or too
/// many.
std::vector<std::size_t> columns_in_order(const TextLine& line, const TargetKind& kind);

/// Reads a line of comma-separated numbers into `row`, which holds one value per column of the kind; NaN for
/// those that are not given. An empty cell of an optional column counts as not given. Errors: number of
/// cells; a cell that is no number or breaks its column's rule; see check_row().
void parse_cells(const TextLine& line, const TargetKind& kind, std::span<const std::size_t> column_of_cell,
                 std::span<double> row);

}  // namespace alidade
