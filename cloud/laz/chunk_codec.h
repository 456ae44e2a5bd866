// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cloud/laz/layered_codec.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/pointwise_codec.h"

namespace alidade {

/// Takes `count` point data records of a chunk. The first one is the chunk's point number `first`. Records
/// are contiguous, and valid only until the call returns.
using TakeRecords = std::function<void(const std::byte* records, std::size_t count, std::uint64_t first)>;

/// Unpacks chunks of any compressor, one after another. Keeps its memory between chunks. Not thread safe:
/// one per thread.
class ChunkDecoder {
 public:
  /// With compressor 3, fields of layers that are not wanted are not unpacked: their values are undefined.
  ChunkDecoder(const LazLayout& layout, const LazLayers& wanted);

  /// Unpacks the chunk that begins at bytes[0] and holds `point_count` points. Returns the number of bytes it
  /// took: all of a layered chunk; of a pointwise one those up to the end of its last point. Errors:
  /// CorruptChunk. Memory: some thousand records of a pointwise chunk; all records of a layered one that
  /// could be unpacked.
  std::size_t decode(std::span<const std::byte> bytes, std::uint64_t point_count, const TakeRecords& take);

 private:
  std::byte* records(std::uint64_t count);

  std::size_t record_size_;
  std::optional<PointwiseDecoder> pointwise_;
  std::optional<LayeredDecoder> layered_;
  std::unique_ptr<std::byte[]> records_;
  std::uint64_t record_room_ = 0;
};

/// Packs chunks by the rules of any compressor, one after another. Not thread safe: one per thread.
class ChunkEncoder {
 public:
  /// Requires what LayeredEncoder or PointwiseEncoder requires. Errors: as theirs.
  explicit ChunkEncoder(const LazLayout& layout) {
    if (layout.compressor == LazCompressor::layered) {
      layered_.emplace(layout);
    } else {
      pointwise_.emplace(layout);
    }
  }

  /// Packs one chunk. Requires a whole number of records, at least one.
  std::vector<std::byte> encode(std::span<const std::byte> records) {
    return layered_ ? layered_->encode(records) : pointwise_->encode(records);
  }

 private:
  std::optional<LayeredEncoder> layered_;
  std::optional<PointwiseEncoder> pointwise_;
};

}  // namespace alidade
