// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Layers of a layered chunk: POINT14 has nine, RGB14 and WAVEPACKET14 one, RGBNIR14 two, BYTE14 one per
/// byte. Errors: CorruptChunk, if the layout has items that layered chunks do not have, or does not begin
/// with its only POINT14.
std::size_t count_layers(const LazLayout& layout);

/// Beginning of a layered LAZ chunk: the first record as it is, the number of points (u32), the bytes of each
/// layer (u32). The layers follow in the order of their sizes.
class LayeredChunkHead {
 public:
  /// Errors: as count_layers().
  explicit LayeredChunkHead(const LazLayout& layout);

  /// Bytes of a head.
  std::size_t size() const { return record_size_ + 4 + 4 * layer_sizes_.size(); }

  /// Reads the head at the start of `bytes`, which may end behind it. Errors: CorruptChunk, if the bytes end
  /// early, there are no points, or a layer is too small for what it must hold.
  void read(std::span<const std::byte> bytes);

  /// Points of the chunk, the first record included.
  std::uint32_t point_count() const { return point_count_; }
  /// Bytes of the layers; 0 for a layer that is left out because all points have the attribute of the first.
  std::span<const std::uint32_t> layer_sizes() const { return layer_sizes_; }
  /// Bytes of the whole chunk, which may be more than those passed to read().
  std::uint64_t chunk_size() const { return chunk_size_; }

 private:
  std::size_t record_size_;
  std::vector<std::uint32_t> layer_sizes_;
  std::uint32_t point_count_ = 0;
  std::uint64_t chunk_size_ = 0;
};

/// Decodes the chunks of LAZ files with LazCompressor::layered, formats 6-10, items of version 2 to 4. For
/// one thread at a time, and any number of chunks. Memory is taken by the first chunk, and by the first with
/// an attribute or a scanner channel that none before it used; it does not depend on the number of points.
class LayeredDecoder {
 public:
  /// Errors: CorruptChunk, if the layout has items that layered chunks do not have.
  explicit LayeredDecoder(const LazLayout& layout, const LazLayers& wanted = {});
  ~LayeredDecoder();

  /// Decodes a chunk that is exactly `chunk` into `records`, whose size is that of the expected points, at
  /// least one. In all records, attributes that are not wanted are those of the chunk's first record. Takes
  /// any bytes. Errors: CorruptChunk, with the point's number in the chunk if a point is the cause; `records`
  /// are then undefined. Cost: linear in the points; layers that are not wanted are not read.
  void decode(std::span<const std::byte> chunk, std::span<std::byte> records);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Encodes chunks of formats 6-10 as LayeredDecoder decodes them, byte for byte like other writers of LAZ.
/// May be used for any number of chunks.
class LayeredEncoder {
 public:
  /// Requires items of version 3 or 4. Errors: as LayeredDecoder.
  explicit LayeredEncoder(const LazLayout& layout);
  ~LayeredEncoder();

  /// Packs one chunk. Requires a whole number of records, at least one. Cost: linear in the records.
  std::vector<std::byte> encode(std::span<const std::byte> records);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alidade
