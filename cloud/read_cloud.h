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

/// How many bits of a LAS colour field are in use. Many files hold 0..255 in 16-bit fields against the
/// standard.
enum class ColorDepth { automatic, bits_8, bits_16 };

struct ReadOptions {
  /// Attributes to keep; others are skipped and take no memory. Positions are always read.
  AttributeSet attributes = AttributeSet::all();
  /// One depth for all LAS files. `automatic`: 8 bits if no channel of any coloured LAS point exceeds 255
  /// (and some channel is not 0), else 16. PointCloud::warnings reports the assumption when it is 8, and when
  /// it is 16 for files that on their own would be 8.
  ColorDepth color_depth = ColorDepth::automatic;
  /// Whether to read the intact part of damaged files. PointCloud::warnings then reports what is lost, file by
  /// file and position by position, and CloudFile::lost_count counts it; otherwise damage is an Error.
  bool partial = false;
  /// Where points are needed, world coordinates, faces included; sides may be infinite. LAS and index files
  /// whose own word for where their points are (FileFacts::box) does not meet it are left unread: the cloud
  /// then holds at least all points within, provided that such headers are right, in rows that RowIds
  /// (cloud/rows.h) numbers as if all had been read. Points of files that are read are not cut off. LAS files of
  /// which a catalog states their box are not even opened, but for the first one and the first with points.
  /// Skipped files affect neither ColorDepth::automatic nor the attributes. Ignored with `partial`.
  std::optional<Bounds> region{};
  Progress progress{};  ///< in bytes of input
};

/// Reads one or more clouds into one. LAS 1.0-1.4 (point formats 0-10), LAZ and COPC of these, PLY, PCD, E57,
/// PTX, PTS, CSV with header names and XYZ are detected by content, never by the file's name; other formats
/// are those that the inputs were resolved with, as index files (octree/index_file/index_file.h), whose points
/// come back in the rows they had.
///
/// Several files are joined in the
/// order given; an attribute that only some files have is filled with zeros for the others (said in
/// `warnings`). LAS files of different lattices are joined on one that holds all their positions exactly, mostly the
/// finest; where none does, those that are rounded are warned of (joined_lattice()). A file that states another
/// coordinate reference system than the others is an Error; one that states none beside others that do is warned of.
/// Heights stay in their unit, unless one unit is wanted (in_one_unit()). Files without a lattice of their own get
/// one fine enough that rounding stays below what the file's own number type can express (or, for double coordinates,
/// the finest power of ten that 32 bits hold). A warning says where rounding costs more than the digits written or
/// the number type had, and more than a millionth of the file's longest side; double coordinates are rounded without
/// one.
///
/// Errors: Error naming file, position, expectation and finding. Memory: the columns of the result plus a
/// constant, and for several files those of 4 million points or an eighth of all, whichever is more; counts
/// in a file are checked against its size before memory is taken. Cost: one pass for LAS and LAZ, two passes
/// for the other formats; several files, and the chunks of LAZ, are read at once by the threads of the task
/// arena (oneTBB), and the result is the same for any number of them.
PointCloud read_cloud(const CloudInputs& inputs, const ReadOptions& options = {});

/// The same for names of files, folders and patterns (resolve_clouds()).
PointCloud read_cloud(std::span<const std::filesystem::path> files, const ReadOptions& options = {});
PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options = {});

/// What files state of their points, before any is selected.
struct StatedSize {
  Bounds box;                         ///< world coordinates (FileFacts::box); empty if no file states one
  std::uint64_t point_count = 0;      ///< of LAS and index files
  AttributeSet attributes{};          ///< of any file
  std::uint64_t uncounted_bytes = 0;  ///< of the files that do not state how many points they have

  /// About the memory that positions and attributes take: extra dimensions are left out, and files that state no number
  /// of points count as large as they are.
  std::uint64_t bytes() const;
};

/// Without files that a catalog states to lie outside of the box of a selection. Errors: those of opening files.
StatedSize stated_size(const CloudInputs& inputs);

/// That box alone; files whose box a catalog states are not opened.
Bounds stated_box(const CloudInputs& inputs);

}  // namespace alidade
