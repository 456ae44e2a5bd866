// SPDX-License-Identifier: MIT
#include "cloud/laz/chunk_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace alidade {
ChunkDecoder::ChunkDecoder(const LazLayout& layout, const LazLayers& wanted)
    : record_size_(layout.record_size()) {
  if (layout.compressor == LazCompressor::layered) {
    layered_.emplace(layout, wanted);
  } else {
    pointwise_.emplace(layout);
  }
}

std::byte* ChunkDecoder::records(std::uint64_t count) {
  if (count > record_room_) {
    records_.reset();
    record_room_ = 0;
    const bool fits = count <= PTRDIFF_MAX / record_size_;
    // Not filled: a chunk that claims more points than it has then takes room for those it has.
    if (fits) records_.reset(new (std::nothrow) std::byte[static_cast<std::size_t>(count * record_size_)]);
    if (!records_) throw CorruptChunk(fmt::format("not enough memory for {} points", count));
    record_room_ = count;
  }
  return records_.get();
}

std::size_t ChunkDecoder::decode(std::span<const std::byte> bytes, std::uint64_t point_count,
                                 const TakeRecords& take) {
  if (layered_) {
    std::byte* const all = records(point_count);
    layered_->decode(bytes, {all, static_cast<std::size_t>(point_count * record_size_)});
    take(all, static_cast<std::size_t>(point_count), 0);
    return bytes.size();
  }
  // So few that their records stay in the cache until they are taken.
  constexpr std::uint64_t k_block_points = 4096;
  pointwise_->start(bytes);
  for (std::uint64_t first = 0; first < point_count; first += k_block_points) {
    const std::size_t count = static_cast<std::size_t>(std::min(k_block_points, point_count - first));
    std::byte* const block = records(count);
    pointwise_->decode({block, count * record_size_});
    take(block, count, first);
  }
  return pointwise_->consumed();
}

}  // namespace alidade
