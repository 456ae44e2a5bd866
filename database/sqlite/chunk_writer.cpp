// SPDX-License-Identifier: MIT
#include "database/sqlite/chunk_writer.h"

#include <algorithm>
#include <span>

#include "database/sqlite/cloud_schema.h"

namespace alidade {

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
