// SPDX-License-Identifier: MIT
#include "database/sqlite/chunk_store.h"

#include <fmt/format.h>

#include <cstring>

#include "cloud/lattice.h"

namespace alidade {

ChunkStore::ChunkStore(sqlite3* database, const std::string& schema, const std::string& table,
                       const CloudSchema& cloud)
    : file_(file_of(database, schema)),
      table_(table),
      lattice_(cloud.lattice),
      boxes_(database, schema, table, cloud.chunk_count),
      positions_(database,
                 "SELECT points, positions FROM " + part_name(schema, table, "chunk") + " WHERE id = ?",
                 Readable::plain_tables, schema),
      values_(database, "SELECT data FROM " + part_name(schema, table, "value") + " WHERE id = ?",
              Readable::plain_tables, schema) {}

void ChunkStore::refuse(std::uint64_t chunk, std::string problem, std::string expected,
                        std::string found) const {
  throw SqliteError(SQLITE_CORRUPT_VTAB, {.file = file_,
                                          .place = fmt::format("{}, chunk {}", table_, chunk),
                                          .problem = std::move(problem),
                                          .expected = std::move(expected),
                                          .found = std::move(found)});
}

std::vector<ChunkPlace> ChunkStore::chunks(const PointFilter& filter, std::optional<std::uint64_t> only) {
  const auto wanted = [&](const Bounds& box) { return may_hold(filter, box); };
  if (!only) return boxes_.chunks(wanted);
  const std::optional<ChunkPlace> place = boxes_.chunk(*only);
  return place && wanted(place->box) ? std::vector{*place} : std::vector<ChunkPlace>();
}

std::shared_ptr<StoredChunk> ChunkStore::read(const ChunkPlace& place) {
  const std::uint64_t id = place.id;
  positions_.bind(1, static_cast<std::int64_t>(id));
  if (!positions_.step()) {
    positions_.reset();
    refuse(id, "is not there", "a row of the table of chunks", "");
  }
  const std::int64_t count = positions_.whole(0);
  const std::span<const std::byte> bytes = positions_.bytes(1);
  auto chunk = std::make_shared<StoredChunk>();
  chunk->id = id;
  const std::size_t size = bytes.size();
  const bool fits = size % sizeof(LatticePosition) == 0 &&
                    static_cast<std::int64_t>(size / sizeof(LatticePosition)) == count;
  if (fits && size > 0) {
    chunk->positions.resize(size / sizeof(LatticePosition));
    std::memcpy(chunk->positions.data(), bytes.data(), size);
  }
  positions_.reset();
  if (!fits) {
    refuse(id, "its positions have another size than its points need",
           fmt::format("{} bytes for each of {} points", sizeof(LatticePosition), count),
           fmt::format("{} bytes", size));
  }
  LatticeExtent extent;
  for (const LatticePosition& position : chunk->positions) extent.grow(position);
  if (!chunk->positions.empty() &&
      (to_world(lattice_, extent.low) != place.box.min || to_world(lattice_, extent.high) != place.box.max))
    refuse(id, "its points do not fill its box", "the box around them", "");
  return chunk;
}

const std::byte* ChunkStore::bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) {
  const auto blob = static_cast<std::size_t>(column.blob);
  const auto size = static_cast<std::size_t>(column.size);
  if (chunk.blobs.size() <= blob) chunk.blobs.resize(blob + 1);
  if (!chunk.blobs[blob]) {
    values_.bind(1, value_id(column.blob, chunk.id));
    const bool is_there = values_.step();
    const std::span<const std::byte> stored = is_there ? values_.bytes(0) : std::span<const std::byte>();
    chunk.blobs[blob].emplace(stored.begin(), stored.end());
    values_.reset();
  }
  // Each time, since columns may disagree about the blob they share.
  if (chunk.blobs[blob]->size() != size * chunk.positions.size()) {
    refuse(chunk.id, fmt::format("the values of {} have another size than its points need", column.name),
           fmt::format("{} bytes for each of {} points", size, chunk.positions.size()),
           fmt::format("{} bytes", chunk.blobs[blob]->size()));
  }
  return chunk.blobs[blob]->data() + row * size + static_cast<std::size_t>(column.place);
}

}  // namespace alidade
