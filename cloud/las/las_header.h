// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "base/input_file.h"
#include "cloud/damage.h"
#include "cloud/lattice.h"

namespace alidade {

/// Byte offsets of the fields of a LAS point data record; -1 = the format does not have the field. Formats
/// 0-5 ("legacy") and 6-10 begin differently:
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

/// Layouts of the point data record formats 0 to 10. Wave packets (4, 5, 9, 10) are the last field of their
/// records and are never read.
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

inline constexpr std::size_t k_las_header_size = 375;                 ///< of version 1.4, the longest
inline constexpr std::uint16_t k_las_gps_time_is_standard = 1u << 0;  ///< bits of the global encoding
inline constexpr std::uint16_t k_las_crs_is_wkt = 1u << 4;

/// The public header block of a LAS file of any version, in the terms of version 1.4.
struct LasHeader {
  std::uint16_t file_source_id = 0;
  std::uint16_t global_encoding = 0;
  std::array<std::uint8_t, 16> project_id{};
  int version_minor = 4;  ///< the major version is always 1
  std::string system_identifier;
  std::string generating_software;
  std::uint16_t creation_day = 0;  ///< of the year, 1 = 1 January; 0 = unknown
  std::uint16_t creation_year = 0;
  std::uint16_t header_size = k_las_header_size;
  std::uint32_t points_offset = 0;  ///< byte of the first point
  std::uint32_t record_count = 0;   ///< variable length records between header and points
  int point_format = 6;
  bool compressed = false;        ///< LAZ, as the record "laszip encoded" describes
  std::uint16_t point_size = 30;  ///< bytes per point, with extra bytes; of LAZ, once unpacked
  std::uint64_t point_count = 0;  ///< points inside the file; of LAZ, as stated
  std::uint64_t lost_count = 0;   ///< announced, but behind the end of the file (Damage::read_over)
  std::array<std::uint64_t, 15> points_by_return{};  ///< not read, only written
  Lattice lattice;
  Bounds bounds;  ///< as stated, which is wrong in many files; empty if invalid
  std::uint64_t extended_records_offset = 0;
  std::uint32_t extended_record_count = 0;

  const LasPointLayout& layout() const { return k_las_point_layouts[static_cast<std::size_t>(point_format)]; }
  /// Behind the last byte of the points; a lower bound of that for compressed points.
  std::uint64_t points_end() const {
    return compressed ? points_offset : points_offset + point_count * point_size;
  }
};

/// Reads and checks the header: afterwards all fields have meaningful values, and all points lie inside the
/// file or, compressed, are not more than its bytes can hold. Harmless oddities are added to `warnings`.
/// Errors: not LAS, a version after 1.4, invalid values; a file that ends before its last point is damage.
LasHeader read_las_header(InputFile& file, std::vector<std::string>& warnings,
                          Damage damage = Damage::reject);

/// Counts the uncompressed points that lie inside the file; points behind its end are damage.
void keep_points_inside(const InputFile& file, LasHeader& header, Damage damage);

/// The header as 375 bytes of version 1.4. Requires a point format of 6 or more (legacy counts are then 0).
std::array<std::byte, k_las_header_size> encode_las_header(const LasHeader& header);

/// Text of a field of fixed length, up to its first NUL.
std::string las_text(const std::byte* field, std::size_t length);
/// At most `length` bytes of a text, cut between two UTF-8 characters.
std::string cut_las_text(const std::string& text, std::size_t length);
/// Writes cut_las_text() into a field of fixed length that is zero.
void store_las_text(std::byte* field, std::size_t length, const std::string& text);

}  // namespace alidade
