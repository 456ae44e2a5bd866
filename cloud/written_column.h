// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Gives the points from `first` on, at least one, as many as it likes; all pieces have the same attributes.
using PointPieces = std::function<const PointCloud&(std::size_t first)>;

/// A column that a format of named columns gets, and where its values come from.
struct WrittenColumn {
  std::string name;
  ScalarType type = ScalarType::float64;  ///< bytes are left out
  std::function<double(std::size_t row)> value;
};

/// x, y, z as double, then nx ny nz, red green blue (`color_bits` 8: uint8, rounded; else uint16) and the other
/// attributes that are present, under the names other programs know; flags as class_flags, scan_channel,
/// scan_direction_flag and edge_of_flight_line. Then the extra dimensions, those with a scale as the values they
/// mean and 64-bit integers as double, under names without blanks that are given once. A value that is marked as none is
/// NaN, so that whole numbers with such a mark are double, too. The cloud must outlive them.
std::vector<WrittenColumn> written_columns(const PointCloud& cloud, int color_bits);

/// Appends the shortest digits that give the same number of that type again.
void append_number(std::string& text, ScalarType type, double number);

}  // namespace alidade
