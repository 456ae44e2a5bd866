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
/// byte. Errors: CorruptChunk, if the layout has items that layered chunks do not have, or is not one POINT14
/// and then others.
std::size_t count_layers(const LazLayout& layout);

/// Beginning of a layered LAZ chunk: the first record as it is, the number of points u32, the bytes of each
/// layer u32. The layers follow in the same order.
class LayeredChunkHead {
 public:
  /// Errors: as count_layers().
  explicit LayeredChunkHead(const LazLayout& layout);

  /// Bytes of a head.
  std::size_t size() const { return record_size_ + 4 + 4 * layer_sizes_.size(); }

  /// Reads the head at the start of `bytes`, which may end behind it. Errors: CorruptChunk, if the bytes end
  /// early, there are no points, or a layer is too small for what it must hold.
  void read(std::span<const std::byte> bytes);

  /// Including the first.
  std::uint32_t point_count() const { return point_count_; }
  /// Bytes of the layers; 0 of those left out because their attribute is that of the first point in all
  /// points.
  std::span<const std::uint32_t> layer_sizes() const { return layer_sizes_; }
  /// Bytes of the whole chunk, which may be more than `bytes` had.
  std::uint64_t chunk_size() const { return chunk_size_; }

 private:
  std::size_t record_size_;
  std::vector<std::uint32_t> layer_sizes_;
  std::uint32_t point_count_ = 0;
  std::uint64_t chunk_size_ = 0;
};

/// Decodes the chunks of LAZ files with LazCompressor::layered, formats 6-10, items of version 2 to 4. One
/// decoder is for one thread, and for any number of chunks: memory is taken by the first of them, and by the
/// first with an attribute or a scanner channel that none before it used; never by the number of points.
class LayeredDecoder {
 public:
  /// Errors: CorruptChunk, if the layout has items that layered chunks do not have.
  explicit LayeredDecoder(const LazLayout& layout, const LazLayers& wanted = {});
  ~LayeredDecoder();

  /// Decodes a chunk that is exactly `chunk` into `records`, whose size says how many points are expected, at
  /// least one. Attributes that are not wanted are those of the chunk's first record in all records.
  /// Errors: CorruptChunk, with the point's number in the chunk if one is concerned; `records` then hold
  /// anything. The bytes may be any. Layers that are not wanted are not read. Cost: linear in the
  /// points, not in the bytes of layers that are not wanted.
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

  /// One chunk. Requires a whole number of records, at least one. Cost: linear in the records.
  std::vector<std::byte> encode(std::span<const std::byte> records);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alidade
