// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "visibility/lines/line_report.h"
#include "visibility/observers.h"
#include "visibility/row_text.h"

namespace alidade::visibility {

/// Two ends of a sight line as a file gives them.
struct GivenPair {
  GivenObserver from, to;
  bool has_positions = false;  ///< otherwise only names
};

/// Reads pairs from CSV: a header with the names of the columns in any order, then a row each: `from` and
/// `to` are names; `from_x`, `from_y`, `to_x`, `to_y` positions in the cloud's coordinates, `from_z` and
/// `to_z` what they are on (empty: the ground), `from_height` and `to_height` their height above it. Either
/// names or positions are required. Blank lines are skipped. Errors, naming the line: an unknown or repeated
/// column; a position without its other coordinates; a cell that is not a finite number; an empty name where
/// there is no position; too many or too few cells; no row at all.
std::vector<GivenPair> read_pair_table(const std::filesystem::path& path);

/// The contents of files that report on sight lines.
struct LineTable {
  std::vector<LinePair> pairs;
  std::vector<LineReport> reports;                ///< one per pair
  std::span<const std::uint8_t> classifications;  ///< by point id; empty if the cloud has none
  std::vector<double> unscanned{};                ///< unscanned_length() of every pair; empty: no such column
  LineMeasures measures{};                        ///< with the results of these lines
};

/// A line as a row of named values, in the order of the columns; null if a value does not apply. All rows of
/// a table have the same names; tools/manuals/visibility_lines.txt describes them. Classes are those of the
/// points.
Row line_row(const LineTable& table, std::size_t line);

/// Writes the reports; the file is written completely or not at all.
/// - CSV: a header and a row per line, with the columns of `alidade visibility lines --help`.
/// - JSON: an object with the `lines`, each with the same names and the members of its measures.
/// - GeoJSON: a LineString per line, or two for one that is blocked: `visible` up to the blocker, the rest
///   not; the columns are the properties of both. Coordinates are longitude, latitude and the cloud's z;
///   without `to_lon_lat`, or if it returns nothing, those of the cloud, which maps cannot show: the
///   function returns false then.
/// Errors: an existing file without `overwrite`; a full disk and other write failures. Requires a line.
bool write_lines(const LineTable& table, RowForm form, const RowFileHead& head, const ToLonLat& to_lon_lat,
                 const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
