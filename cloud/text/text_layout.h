// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "cloud/crs.h"
#include "cloud/point_table.h"

namespace alidade {

/// How the lines of a text file of points are read, detected from its first lines.
///
/// - Comments are lines that begin with # or //. They and empty lines are left out everywhere.
/// - Titles are the first line with words that are not numbers, or else a comment before the first point that
///   has a title for each column. Titles have x and y among them. A unit in brackets at the end of a title
///   applies: coordinates in feet make a system in feet, times and scan angles in other units than seconds
///   and degrees are extra dimensions.
/// - A line with one whole number before the first point makes a PTS file: blocks of a count line and that
///   many points. Titles may come before or after the first count.
/// - Without titles, the number of columns and the values of the first 256 points determine their roles.
///   Colours are three columns of whole numbers 0 .. 65535 or of numbers 0 .. 1, normals three columns of
///   vectors of length 1 (or 0). The first layout of the list that fits applies; if none does, the columns
///   become extra dimensions column_4, column_5, ...
///     3  x y z
///     4  x y z intensity
///     6  x y z normal | x y z color
///     7  x y z intensity color | x y z color intensity | x y z intensity normal | x y z normal intensity
///     9  x y z color normal | x y z normal color
///    10  x y z intensity color normal | x y z color intensity normal | x y z color normal intensity
/// - Columns are separated by semicolons if the titles or the first point have one outside quotes, else by
///   commas, else by blanks and tabs. If no comma separates them, numbers may have decimal commas, but then
///   all of them.
struct TextLayout {
  std::string format;               ///< "XYZ", "CSV" or "PTS"
  char separator = ' ';             ///< ' ' is any blanks and tabs
  bool has_decimal_commas = false;  ///< a number of the first points has one
  bool has_blocks = false;          ///< count lines, each before its points
  std::vector<TableColumn> columns;
  bool has_names = false;            ///< columns have names of their own; words in extra columns become NaN
  Crs crs{};                         ///< of coordinates whose titles state another unit than metres
  std::uint64_t data_offset = 0;     ///< first byte behind comments
  std::uint64_t line_count = 0;      ///< lines before that
  std::uint64_t title_line = 0;      ///< number of the line of titles, unless it is a comment; 0: none
  std::vector<std::string> remarks;  ///< on assumptions, as clauses
};

/// Detects the layout of a file. `names` are those of the columns and replace its titles; empty: as above.
/// Errors: a first line of words without the names of coordinates; fewer than three columns without names;
/// more or fewer names than columns; coordinates in an unknown unit. A file without lines has no points and
/// is XYZ.
TextLayout read_text_layout(InputFile& input, std::span<const std::string> names);

/// Whether a line has no data.
bool is_comment_or_empty(std::string_view line);

/// Whether a cell states that there is no value: it is empty, "-", "nil", "null", "NA" or the like.
bool is_missing(std::string_view word);

/// Splits a line. An empty cell behind the last separator is left out if the line has more cells than
/// `column_count`.
void split_line(std::string_view line, char separator, std::size_t column_count,
                std::vector<std::string_view>& words);

}  // namespace alidade
