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
/// intensity (ushort) and the other attributes and extra dimensions that are present, under their usual
/// names; flags as class_flags, scan_channel, scan_direction_flag and edge_of_flight_line. Keeps the order of
/// the points.
///
/// Reading the file onto the cloud's own lattice restores the positions, and all values but colours. Extra
/// dimensions with a scale are written as scaled values, and 64-bit integers, which PLY lacks, as double;
/// undocumented bytes, CRS and LAS records are left out. Errors: as OutputFile.
void write_ply(const std::filesystem::path& path, const PointCloud& cloud,
               const PlyWriteOptions& options = {});

/// Writes a cloud of `point_count` points that arrives in pieces, with memory for one of them.
void write_ply(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
               const PlyWriteOptions& options = {});

}  // namespace alidade
