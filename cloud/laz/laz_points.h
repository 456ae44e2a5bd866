// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/progress.h"
#include "cloud/damage.h"
#include "cloud/las/las_header.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Receiver of the points of a LAZ file. Rows count from 0.
class LazSink {
 public:
  virtual ~LazSink() = default;
  /// Makes room for `count` rows behind the existing ones, once all of these have been taken. Never more than
  /// 64 MB of records, unless a layered chunk has more.
  virtual void make_room(std::uint64_t count) = 0;
  /// Whether the last `count` rows that there is room for already have their values: then take() is not
  /// called for them.
  virtual bool has_values(std::uint64_t /*count*/) { return false; }
  /// Writes records into rows that there is room for. Called by several threads at once, for different rows.
  virtual void take(const std::byte* records, std::size_t count, std::uint64_t first_row) = 0;
};

/// The point data records of a LAZ file, unpacked chunk by chunk. Not thread safe.
class LazPoints {
 public:
  /// Finds the chunks. If there is no chunk table, layered chunks are found by their own heads, and pointwise
  /// ones of one size while they are unpacked; warnings() then has a warning. Errors: an invalid table, and a
  /// missing one where it is needed; both are damage. File, header and layout must outlive this object.
  LazPoints(InputFile& file, const LasHeader& header, const LazLayout& layout, Damage damage);

  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Passes the points of the file to `sink` in their order; of layered files only the `wanted` fields.
  /// Chunks are unpacked in parallel (oneTBB), the file is read by the calling thread, and the rows are the
  /// same on any number of threads. `progress` is in bytes.
  /// Errors: the first chunk that is damaged, with its number and that of the point within the file, both
  /// from 0. With Damage::read_over such chunks are left out and reported instead; in a single stream, and in
  /// chunks without a table, all points behind the damage and up to some thousand before it are lost. Memory:
  /// some 16 MiB (80 with Damage::read_over), or as much as the largest chunk packed and, if layered,
  /// unpacked; points that a file only claims to have take none.
  std::vector<LostPoints> read(const LazLayers& wanted, LazSink& sink, const Progress& progress);

 private:
  class Unpacker;

  void walk(Damage damage);
  InputFile& file_;
  const LasHeader& header_;
  const LazLayout& layout_;
  Damage damage_;
  std::vector<std::string> warnings_;
  std::vector<LazChunk> chunks_;
  std::vector<LostPoints> lost_;  ///< of chunks that cannot be found
  bool in_sequence_ = false;      ///< pointwise without a table: a chunk's end is known once it is unpacked
};

}  // namespace alidade
