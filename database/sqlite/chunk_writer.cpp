// SPDX-License-Identifier: MIT
#include "database/sqlite/chunk_writer.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "database/sqlite/cloud_schema.h"

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

ChunkWriter::ChunkWriter(sqlite3* database, const std::string& table, const ChunkEncoding& encoding)
    : encoding_(encoding),
      chunk_(database, "INSERT INTO " + part_name("main", table, "chunk") + " VALUES(?,?,?)"),
      value_(database, "INSERT INTO " + part_name("main", table, "value") + " VALUES(?,?)") {}

void ChunkWriter::write(const EncodedChunks& chunks) {
  const std::size_t count = chunks.positions.size();
  const std::uint64_t first = boxes_.size();
  const auto points_of = [&](std::size_t chunk) {
    return std::min<std::size_t>(encoding_.chunk_points, count - chunk * encoding_.chunk_points);
  };
  for (std::size_t chunk = 0; chunk < chunks.boxes.size(); ++chunk) {
    const auto positions =
        std::span(chunks.positions).subspan(chunk * encoding_.chunk_points, points_of(chunk));
    chunk_.bind(1, static_cast<std::int64_t>(first + chunk));
    chunk_.bind(2, static_cast<std::int64_t>(positions.size())).bind(3, std::as_bytes(positions)).run();
  }
  // Blob by blob, since those of one number stand beside each other.
  for (std::size_t blob = 0; blob < chunks.blobs.size(); ++blob) {
    const std::size_t size = count == 0 ? 0 : chunks.blobs[blob].size() / count;
    for (std::size_t chunk = 0; chunk < chunks.boxes.size(); ++chunk) {
      value_.bind(1, value_id(static_cast<int>(blob), first + chunk));
      value_.bind(2, std::span(chunks.blobs[blob])
                         .subspan(chunk * encoding_.chunk_points * size, points_of(chunk) * size));
      value_.run();
    }
  }
  boxes_.insert(boxes_.end(), chunks.boxes.begin(), chunks.boxes.end());
}

}  // namespace alidade
