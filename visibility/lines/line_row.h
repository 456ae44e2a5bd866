// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "visibility/lines/line_files.h"
#include "visibility/row_text.h"

namespace alidade {

/// A line as a row of named values, in the order of the columns; null where there is nothing to say. All rows
/// of a table have the same names. Lengths and places along the line from its first end, in `..._at`, are in
/// the cloud's unit; shares are 0 .. 1; classes are those of the points. See docs/visibility.md for every
/// column.
Row line_row(const LineTable& table, std::size_t line);

/// What obstructs the Fresnel zone of a line: `points` by their share of it, and `classes`; of a line without
/// a zone empty.
Row line_obstructions(const LineTable& table, std::size_t line);

}  // namespace alidade
