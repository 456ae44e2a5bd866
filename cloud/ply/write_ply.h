// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "cloud/written_column.h"

namespace alidade {

enum class PlyEncoding { ascii, binary_little_endian };

struct PlyWriteOptions {
  PlyEncoding encoding = PlyEncoding::binary_little_endian;
  bool overwrite = false;
  Progress progress{};  ///< in points
};

/// Writes a cloud as PLY: double x y z, then nx ny nz, red green blue (uchar: colours are rounded to 8 bits),
/// intensity (ushort) and the other attributes and extra dimensions that are present, under the names other
/// programs know; flags as class_flags, scan_channel, scan_direction_flag and edge_of_flight_line. Point
/// order is kept.
///
/// Read again onto the cloud's own lattice, positions come out as the same steps and everything but colours
/// as the same values. Extra dimensions with a scale are written as the values they mean, and 64-bit
/// integers, which PLY lacks, as double; undocumented bytes, CRS and LAS records are left out. Errors: as
/// OutputFile.
void write_ply(const std::filesystem::path& path, const PointCloud& cloud,
               const PlyWriteOptions& options = {});

/// The same for a cloud of so many points that comes in pieces, with memory for one of them.
void write_ply(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
               const PlyWriteOptions& options = {});

}  // namespace alidade
