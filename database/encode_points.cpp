// SPDX-License-Identifier: MIT
#include "database/encode_points.h"

#include <cstring>

namespace alidade {
namespace {

/// Copies `k_size` bytes per point, which the compiler then does without a call.
template <std::size_t k_size>
void gather(const PickedPoints& points, std::size_t blob, std::size_t, std::byte* place) {
  for (const auto& [block, row] : points.picks) {
    if (const std::byte* const values = block->blobs[blob].values)
      std::memcpy(place, values + row * k_size, k_size);
    place += k_size;
  }
}

void gather_any(const PickedPoints& points, std::size_t blob, std::size_t size, std::byte* place) {
  for (const auto& [block, row] : points.picks) {
    if (const std::byte* const values = block->blobs[blob].values)
      std::memcpy(place, values + row * size, size);
    place += size;
  }
}

auto gatherer(std::size_t size) {
  switch (size) {
    case 1:
      return &gather<1>;
    case 2:
      return &gather<2>;
    case 4:
      return &gather<4>;
    case 6:
      return &gather<6>;
    case 8:
      return &gather<8>;
    default:
      return &gather_any;
  }
}

/// Spreads values of the rows concerned, `count` to a point.
void spread_values(const ColorSpread& spread, const PickedPoints& points, std::size_t count,
                   std::vector<std::byte>& bytes) {
  std::byte* place = bytes.data();
  for (const auto& [block, row] : points.picks) {
    const bool is_concerned = spread.concerns(block->id(row));
    for (std::size_t i = 0; i < count; ++i, place += sizeof(std::uint16_t)) {
      std::uint16_t value;
      std::memcpy(&value, place, sizeof value);
      if (is_concerned) value = ColorSpread::spread(value);
      std::memcpy(place, &value, sizeof value);
    }
  }
}

}  // namespace

EncodedChunks encode(const ChunkEncoding& encoding, const PickedPoints& points) {
  EncodedChunks chunks;
  const std::size_t count = points.picks.size();
  chunks.positions.resize(count);
  std::vector<std::byte>& ids = chunks.blobs.emplace_back(count * sizeof(std::uint64_t));
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [block, row] = points.picks[i];
    chunks.positions[i] = block->positions[row];
    const std::uint64_t id = block->id(row);
    std::memcpy(ids.data() + i * sizeof id, &id, sizeof id);
    if (i % encoding.chunk_points == 0) chunks.boxes.emplace_back();
    chunks.boxes.back().grow(to_world(encoding.lattice, chunks.positions[i]));
  }
  for (std::size_t blob = 0; blob < encoding.blobs.size(); ++blob) {
    const ValueBlob& about = encoding.blobs[blob];
    std::vector<std::byte>& bytes = chunks.blobs.emplace_back(count * about.size);
    gatherer(about.size)(points, blob, about.size, bytes.data());
    if (encoding.spread.colors && about.is(Attribute::color))
      spread_values(encoding.spread, points, 3, bytes);
    if (encoding.spread.near_infrared && about.is(Attribute::near_infrared))
      spread_values(encoding.spread, points, 1, bytes);
  }
  return chunks;
}

}  // namespace alidade
