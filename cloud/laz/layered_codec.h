// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "cloud/laz/laz_layers.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Decodes the chunks of LAZ files with LazCompressor::layered, formats 6-10, items of version 2 to 4. One
/// decoder is for one thread, and for any number of chunks: memory is taken by the first of them, and by the
/// first with an attribute or a scanner channel that none before it used; never by the number of points.
class LayeredDecoder {
 public:
  /// Errors: CorruptChunk, if the layout has items that layered chunks do not have.
  explicit LayeredDecoder(const LazLayout& layout, const LazLayers& wanted = {});
  LayeredDecoder(LayeredDecoder&&) noexcept;
  LayeredDecoder& operator=(LayeredDecoder&&) noexcept;
  ~LayeredDecoder();

  /// Decodes a chunk that is exactly `chunk` into `records`, whose size says how many points are expected, at
  /// least one. Attributes that are not wanted are those of the chunk's first record in all records.
  /// Errors: CorruptChunk, with the point's number in the chunk if one is concerned; `records` then hold
  /// anything. The bytes may be any. Layers that are not wanted are not looked at. Cost: linear in the
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
  LayeredEncoder(LayeredEncoder&&) noexcept;
  LayeredEncoder& operator=(LayeredEncoder&&) noexcept;
  ~LayeredEncoder();

  /// One chunk. Requires a whole number of records, at least one. Cost: linear in the records.
  std::vector<std::byte> encode(std::span<const std::byte> records);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alidade
