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

/// Takes `count` point data records of a chunk. The first one is the chunk's point number `first`. Records are
/// contiguous, and valid only until the call returns.
using TakeRecords = std::function<void(const std::byte* records, std::size_t count, std::uint64_t first)>;

/// Unpacks chunks of whatever compressor, one after another. Keeps its memory between chunks. Not thread
/// safe: one per thread.
class ChunkDecoder {
 public:
  /// Of compressor 3, fields of layers that are not wanted are not unpacked and hold anything.
  ChunkDecoder(const LazLayout& layout, const LazLayers& wanted);

  /// Unpacks the chunk that begins at bytes[0] and holds `point_count` points. Answers how many bytes it
  /// took: all of them but of pointwise chunks, which end where their last point ends. Errors: CorruptChunk.
  /// Memory: of pointwise chunks some thousand records; of layered ones all records, but none that could not
  /// be unpacked.
  std::size_t decode(std::span<const std::byte> bytes, std::uint64_t point_count, const TakeRecords& take);

 private:
  std::byte* records(std::uint64_t count);

  std::size_t record_size_;
  std::optional<PointwiseDecoder> pointwise_;
  std::optional<LayeredDecoder> layered_;
  std::unique_ptr<std::byte[]> records_;
  std::uint64_t record_room_ = 0;
};

/// Packs chunks by the rules of whatever compressor, one after another. Not thread safe: one per thread.
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

  /// One chunk. Requires a whole number of records, at least one.
  std::vector<std::byte> encode(std::span<const std::byte> records) {
    return layered_ ? layered_->encode(records) : pointwise_->encode(records);
  }

 private:
  std::optional<LayeredEncoder> layered_;
  std::optional<PointwiseEncoder> pointwise_;
};

}  // namespace alidade
