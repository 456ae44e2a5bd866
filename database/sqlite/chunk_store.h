// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "database/point_filter.h"
#include "database/sqlite/box_tree.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/statement.h"

namespace alidade {

/// Points of a chunk, as they stand in the database.
struct StoredChunk {
  std::uint64_t id = 0;
  std::vector<LatticePosition> positions;
  std::vector<std::optional<std::vector<std::byte>>> blobs;  ///< those read so far
};

/// The chunks of one cloud. Errors: SQLite's, and chunks that are not there or too short, with their number.
class ChunkStore {
 public:
  /// What it is given must outlive it.
  ChunkStore(sqlite3* database, const std::string& schema, const std::string& table,
             const CloudSchema& cloud);

  /// Chunks that may have points for which the filter holds, by id. Cost: as BoxTree::chunks().
  std::vector<ChunkPlace> chunks(const PointFilter& filter);

  std::shared_ptr<StoredChunk> read(std::uint64_t id);

  /// The bytes of a point in the column's blob, which is read if it is not there yet.
  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row);

 private:
  [[noreturn]] void refuse(std::uint64_t chunk, std::string problem, std::string expected,
                           std::string found) const;

  std::string table_;
  BoxTree boxes_;
  Statement positions_, values_;
};

}  // namespace alidade
