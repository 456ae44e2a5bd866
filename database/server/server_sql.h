// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "cloud/read_in_pieces.h"

namespace alidade {

// Beside a cloud NAME on a server stands the table NAME_cloud. Its one row says what the points' rows cannot:
//   version                           of this table: 1
//   scale_x .. scale_z, offset_x .. offset_z  the lattice
//   points                            how many there are
//   min_x .. min_z, max_x .. max_z    a box around them; NULL if there are none
//   crs                               WKT
//   geotiff_keys, geotiff_doubles, geotiff_ascii  bytes, little endian
//   gps_time_is_standard

inline constexpr int k_cloud_row_version = 1;

/// What the row says.
struct CloudRow {
  Lattice lattice;
  std::uint64_t point_count = 0;
  Bounds box;
  Crs crs;
  bool gps_time_is_standard = false;  ///< as PointCloud's
};

/// Of a cloud that was read piece by piece, with a box around its points.
CloudRow cloud_row(const PiecewiseCloud& whole, const Bounds& box);

/// The statement that makes the table of that name, which is quoted already.
std::string cloud_row_table(const std::string& quoted_name);

/// The statement that fills it. A WKT that is no text to PostgreSQL (UTF-8 without NUL) is left out.
std::string cloud_row_insert(const std::string& quoted_name, const CloudRow& row);

}  // namespace alidade
