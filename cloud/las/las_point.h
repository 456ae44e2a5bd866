// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace alidade {

/// Where the fields of a LAS point data record stand, in bytes from its start; -1 = the format does not have
/// the field. Formats 0-5 ("legacy") and 6-10 begin differently:
///
///   byte    0  4  8  12         14               15            16          17         18            20 22
///   0-5     x  y  z  intensity  returns + bits   class + bits  scan angle  user data  source id     (gps)
///   6-10    x  y  z  intensity  returns          bits          class       user data  scan angle    source
///   gps
///
/// Source: LAS Specification 1.4 R15, tables 7 to 17.
struct LasPointLayout {
  bool legacy;
  int size;  ///< bytes of a record without extra bytes
  int gps_time;
  int color;
  int near_infrared;
};

inline constexpr int k_las_point_formats = 11;

/// Layouts of the point data record formats 0 to 10. Wave packets (4, 5, 9, 10) stand last in their records
/// and are skipped by everyone.
inline constexpr std::array<LasPointLayout, k_las_point_formats> k_las_point_layouts = {{
    {.legacy = true, .size = 20, .gps_time = -1, .color = -1, .near_infrared = -1},
    {.legacy = true, .size = 28, .gps_time = 20, .color = -1, .near_infrared = -1},
    {.legacy = true, .size = 26, .gps_time = -1, .color = 20, .near_infrared = -1},
    {.legacy = true, .size = 34, .gps_time = 20, .color = 28, .near_infrared = -1},
    {.legacy = true, .size = 57, .gps_time = 20, .color = -1, .near_infrared = -1},
    {.legacy = true, .size = 63, .gps_time = 20, .color = 28, .near_infrared = -1},
    {.legacy = false, .size = 30, .gps_time = 22, .color = -1, .near_infrared = -1},
    {.legacy = false, .size = 36, .gps_time = 22, .color = 30, .near_infrared = -1},
    {.legacy = false, .size = 38, .gps_time = 22, .color = 30, .near_infrared = 36},
    {.legacy = false, .size = 59, .gps_time = 22, .color = -1, .near_infrared = -1},
    {.legacy = false, .size = 67, .gps_time = 22, .color = 30, .near_infrared = 36},
}};

/// One step of the scan angle field of formats 6-10, degrees.
inline constexpr double k_las_scan_angle_step = 0.006;

}  // namespace alidade
