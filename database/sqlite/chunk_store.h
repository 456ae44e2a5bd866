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

/// The chunks of one cloud. Errors: SQLite's, and chunks that are not there, too short or not in their box,
/// with their number.
class ChunkStore {
 public:
  /// What it is given must outlive it.
  ChunkStore(sqlite3* database, const std::string& schema, const std::string& table,
             const CloudSchema& cloud);

  /// Chunks that may have points for which the filter holds, by id; of all, or the only one to look at. Cost:
  /// as BoxTree's.
  std::vector<ChunkPlace> chunks(const PointFilter& filter, std::optional<std::uint64_t> only = std::nullopt);

  std::shared_ptr<StoredChunk> read(const ChunkPlace& place);

  /// The bytes of a point in the column's blob, which is read if it is not there yet.
  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row);

 private:
  [[noreturn]] void refuse(std::uint64_t chunk, std::string problem, std::string expected,
                           std::string found) const;

  std::string file_, table_;
  Lattice lattice_;
  BoxTree boxes_;
  Statement positions_, values_;
};

}  // namespace alidade
