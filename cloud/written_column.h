// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

class OutputFile;

/// Returns points from `first` on, at least one, in pieces of any size; all pieces have the same attributes.
using PointPieces = std::function<const PointCloud&(std::size_t first)>;

/// A column of a format of named columns, with the source of its values.
struct WrittenColumn {
  std::string name;
  ScalarType type = ScalarType::float64;  ///< bytes are left out
  std::function<double(std::size_t row)> value;
};

/// The columns of a cloud: x, y, z as double, then nx ny nz, red green blue (`color_bits` 8: uint8, rounded;
/// else uint16) and the other attributes that are present, under their usual names; flags as class_flags,
/// scan_channel, scan_direction_flag and edge_of_flight_line. Then the extra dimensions under unique names
/// without blanks, those with a scale as scaled values, 64-bit integers as double. Nodata values become NaN,
/// so that integers with a nodata value are double, too. The cloud must outlive the columns.
std::vector<WrittenColumn> written_columns(const PointCloud& cloud, int color_bits);

/// Appends the shortest digits that restore a number of that type.
void append_number(std::string& text, ScalarType type, double number);

/// Writes `point_count` points, a few thousand rows at a time. `begin` takes each piece before its rows and
/// returns the text that precedes them; `append` appends a row of that piece. At least one piece is
/// requested, for the head of the file. `progress` is in points.
void write_rows(OutputFile& output, std::size_t point_count, const PointPieces& pieces,
                const Progress& progress,
                const std::function<std::string(const PointCloud& piece, bool is_first)>& begin,
                const std::function<void(std::string& text, std::size_t row)>& append);

}  // namespace alidade
