// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "base/bounds.h"
#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// How many bits of a LAS colour field are used. Many files store 0..255 in the 16-bit fields, against the
/// standard.
enum class ColorDepth { automatic, bits_8, bits_16 };

struct ReadOptions {
  /// Attributes to keep; others are skipped and take no memory. Positions are always read.
  AttributeSet attributes = AttributeSet::all();
  /// One depth for all LAS files. `automatic`: 8 bits if no channel of any coloured LAS point exceeds 255
  /// (and some channel is not 0), else 16. PointCloud::warnings reports the assumption if it is 8, or if it
  /// is 16 for files that on their own would be 8.
  ColorDepth color_depth = ColorDepth::automatic;
  /// Whether to read the intact part of damaged files. PointCloud::warnings then reports lost points by file
  /// and location, and CloudFile::lost_count counts them; otherwise damage is an Error.
  bool partial = false;
  /// The region where points are needed, world coordinates, faces included; sides may be infinite. LAS and
  /// index files whose box (FileFacts::box) does not meet it are not read: the cloud then has at least all
  /// points within, provided that the boxes of headers are right, in rows that RowIds (cloud/rows.h) numbers
  /// as if all files had been read. Other files are read completely. LAS files whose box a catalog states are
  /// not even opened, except for the first one and the first with points. Skipped files affect neither
  /// ColorDepth::automatic nor the attributes. Ignored with `partial`.
  std::optional<Bounds> region{};
  Progress progress{};  ///< in bytes of input
};

/// Reads one or more clouds into one. LAS 1.0-1.4 (point formats 0-10), LAZ and COPC of these, PLY, PCD, E57,
/// PTX, PTS, CSV with header names and XYZ are detected by content, never by the file's name; other formats
/// are those that the inputs were resolved with, such as index files (octree/index_file/index_file.h), whose
/// points return to their original rows.
///
/// Several files are joined in the given order. An attribute that only some files have is filled with zeros
/// for the others, with a warning. LAS files of different lattices are joined on one that holds all their
/// positions exactly, mostly the finest; if none does (joined_lattice()), `warnings` names the files that are
/// rounded. A file that states another coordinate reference system than the others is an Error; one that
/// states none beside others that do gets a warning. Heights stay in their unit, unless one unit is wanted
/// (in_one_unit()). Files without a lattice of their own get one whose rounding is below the resolution of
/// the file's number type (or, for double coordinates, the finest power of ten that 32 bits hold). Rounding
/// by more than the resolution of the written digits or the number type, and by more than a millionth of the
/// file's longest side, gets a warning; that of double coordinates does not.
///
/// Errors: an Error that names file, location, expectation and finding. Memory: the columns of the result
/// plus a constant, and for several files those of 4 million points or an eighth of all, whichever is more;
/// counts in a file are checked against its size before memory is taken. Cost: one pass for LAS and LAZ, two
/// passes for the other formats. Several files, and the chunks of LAZ, are read in parallel by the threads of
/// the task arena (oneTBB); the result does not depend on their number.
PointCloud read_cloud(const CloudInputs& inputs, const ReadOptions& options = {});

/// read_cloud() for names of files, folders and patterns (resolve_clouds()).
PointCloud read_cloud(std::span<const std::filesystem::path> files, const ReadOptions& options = {});
PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options = {});

/// What files state about their points, before any selection.
struct StatedSize {
  Bounds box;                         ///< world coordinates (FileFacts::box); empty if no file states one
  std::uint64_t point_count = 0;      ///< of LAS and index files
  AttributeSet attributes{};          ///< of any file
  std::uint64_t uncounted_bytes = 0;  ///< of the files that do not state a number of points

  /// Estimate of the memory for positions and attributes, without extra dimensions. Files that state no
  /// number of points count with their size.
  std::uint64_t bytes() const;
};

/// What the files state. Leaves out files that, by a catalog, lie outside of the box of a selection. Errors:
/// those of opening files.
StatedSize stated_size(const CloudInputs& inputs);

/// StatedSize::box alone; does not open files whose box a catalog states.
Bounds stated_box(const CloudInputs& inputs);

}  // namespace alidade
