// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "octree/cloud/point_cloud.h"
#include "octree/progress.h"

namespace alidade {

/// How many bits of a LAS colour field are in use. Many files hold 0..255 in 16-bit fields against the
/// standard.
enum class ColorDepth { automatic, bits_8, bits_16 };

struct ReadOptions {
  /// Attributes to keep; others are skipped and take no memory. Positions are always read.
  AttributeSet attributes = AttributeSet::all();
  /// One depth for all LAS files. `automatic`: 8 bits if no channel of any coloured LAS point exceeds 255
  /// (and some channel is not 0), else 16. What was assumed stands in PointCloud::warnings when it is 8, and
  /// when it is 16 for files that on their own would be 8.
  ColorDepth color_depth = ColorDepth::automatic;
  Progress progress{};  ///< in bytes of input
};

/// Reads one or more cloud files into one cloud. The format is told by content, never by the file's name:
/// LAS 1.0-1.4 (point formats 0-10), PLY, PCD, PTX, PTS, CSV with header names, XYZ, and index files
/// (octree/index_file.h), whose points come back in the rows they had.
///
/// Several files are joined in the order given; an attribute that only some files have is filled with zeros
/// for the others (said in `warnings`). LAS files must share one lattice up to a whole number of steps,
/// otherwise the odd file is an Error. Files without a lattice of their own get one fine enough that rounding
/// stays below what the file's own number type can express (or, for double coordinates, the finest power of
/// ten that 32 bits hold). A warning says where rounding costs more than the digits written or the number
/// type had, and more than a millionth of the file's longest side; double coordinates are rounded without
/// one.
///
/// Errors: Error naming file, place, expectation and finding; for LAZ, COPC and E57, that the format is not
/// supported. Memory: the columns of the result plus a constant; counts in a file are checked against its
/// size before memory is taken. Cost: one pass for LAS, two passes for the other formats.
PointCloud read_cloud(std::span<const std::filesystem::path> files, const ReadOptions& options = {});

/// The same for a single file.
PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options = {});

}  // namespace alidade
