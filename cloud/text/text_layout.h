// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "cloud/point_table.h"

namespace alidade {

/// How the lines of a text file of points are to be read; found out from its first lines.
///
/// - A first line with one whole number makes a PTS file: blocks of a count line and that many points.
/// - A first line with a word that is no number is a header of column names. So is a comment right before the
///   points that has a name for each column, x and y among them.
/// - Otherwise columns go by their number and by what the first 256 points hold. Colours are three columns of
/// whole
///   numbers 0 .. 65535 or of numbers 0 .. 1, normals three columns of vectors of length 1 (or 0). The first
///   layout of the list that fits is taken; the columns of others become extra dimensions column_4, column_5,
///   ...
///     3  x y z
///     4  x y z intensity
///     6  x y z normal | x y z color
///     7  x y z intensity color | x y z color intensity | x y z intensity normal | x y z normal intensity
///     9  x y z color normal | x y z normal color
///    10  x y z intensity color normal | x y z color intensity normal | x y z color normal intensity
///
/// Columns are separated by semicolons if the first line has one, else by commas, else by blanks and tabs.
/// Lines that are empty or begin with # or // are left out everywhere.
struct TextLayout {
  std::string format;    ///< "XYZ", "CSV" or "PTS"
  char separator = ' ';  ///< ' ' stands for any blanks and tabs
  std::vector<TableColumn> columns;
  bool has_names = false;            ///< columns have the file's own names; words in extra columns become NaN
  std::uint64_t data_place = 0;      ///< first byte of the points or of the first count line
  std::uint64_t line_count = 0;      ///< lines before that
  std::vector<std::string> remarks;  ///< what was assumed, as clauses
};

/// Errors: a first line of words without the names of coordinates; fewer than three columns; a file without
/// lines has no points and is XYZ.
TextLayout read_text_layout(InputFile& input);

/// Whether a line holds no data.
bool is_comment_or_empty(std::string_view line);

/// Splits a line as the layout says. An empty cell after the last separator is left out.
void split_line(std::string_view line, char separator, std::vector<std::string_view>& words);

}  // namespace alidade
