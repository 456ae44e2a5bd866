// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace alidade
