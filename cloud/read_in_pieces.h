// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "cloud/cloud_reader.h"
#include "cloud/color_spread.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// Why no point of a file is needed. By its box in a catalog, it lies outside of the region (`skipped`) or of
/// the box of a selection (`left_out`). `no`: it may be needed.
enum class Unwanted { no, skipped, left_out };

/// Whether a file is unwanted, so that it need not be opened. Files whose lattice depends on all of their
/// points are always needed, and so is every file if damage is read over.
Unwanted what_is_unwanted(const CloudInput& input, const ReadOptions& options);

/// The result of reading a cloud piece by piece.
struct PiecewiseCloud {
  /// The points that were not handed over, which follow those that were; lattice, reference system, records,
  /// files and warnings of the whole cloud.
  PointCloud rest;
  std::uint64_t point_count = 0;  ///< of the whole cloud
  AttributeSet attributes{};      ///< of any file with points
  /// How colours are still to be spread, including those of the rest.
  ColorSpread spread{};
};

/// read_cloud() for a cloud that may be larger than memory, with the same points in the same rows and the
/// same warnings. Points are handed over in `pieces`, and colours are as in the files. `take` gets clouds on
/// the lattice of the whole cloud; their other facts, such as files and warnings, are not complete yet. Files
/// are read one after another. Errors: as read_cloud(). Memory: that of CloudReader::read().
PiecewiseCloud read_in_pieces(const CloudInputs& inputs, const ReadOptions& options,
                              const CloudPieces& pieces);

}  // namespace alidade
