// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "base/input_file.h"
#include "cloud/cloud_pieces.h"
#include "cloud/read_cloud.h"
#include "cloud/spread_colors.h"

namespace alidade {

/// What is known of a cloud once it has been read piece by piece.
struct PiecewiseCloud {
  /// The points that were not handed over, which come behind all that were; lattice, reference system,
  /// records, files and warnings of the whole.
  PointCloud rest;
  std::uint64_t point_count = 0;  ///< of the whole
  AttributeSet attributes{};      ///< that a file with points has
  /// What remains to be done with the colours, also of the rest.
  ColorSpread spread{};
};

/// read_cloud() for a cloud that memory need not hold: same points in the same rows, same warnings, but
/// points are handed over as `pieces` says, and colours are as the files have them. The pieces' `take` is
/// given clouds on the lattice of the whole; what else they say of it may still grow. Files are read one
/// after another. Errors: as read_cloud(). Memory: that of CloudReader::read_in_pieces().
PiecewiseCloud read_in_pieces(std::span<const std::filesystem::path> files, const ReadOptions& options,
                              const CloudPieces& pieces);

/// The same over files already opened, also in memory.
PiecewiseCloud join_in_pieces(std::vector<InputFile> files, const ReadOptions& options,
                              const CloudPieces& pieces);

}  // namespace alidade
