// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "database/chunk_source.h"
#include "database/point_filter.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/connection.h"

// A tree of boxes: the boxes of a cloud's chunks, boxes around 64 of these, and so on. Unlike SQLite's own
// R*Tree, it is exact (that stores floats) and is queried without a function that only programs linked
// with SQLite can register. Chunks follow a Morton curve, so neighbours in number are neighbours in space.
// A page is the row with the id level * 2^32 + number and has the boxes of 64 chunks (level 0) or pages
// below, or fewer in the last page of a level: least x, y, z, greatest x, y, z as float64 each. The
// topmost level has one page.

namespace alidade::database {

/// Writes the pages for the boxes of all chunks, in the order of their ids, into a table (id, boxes).
void write_box_tree(sqlite3* database, const std::string& table_name, std::vector<Bounds> boxes);

/// Queries a table of write_box_tree().
class BoxTree {
 public:
  /// Opens the boxes of the cloud `table` of one of the connection's databases.
  BoxTree(sqlite3* database, const std::string& schema, const std::string& table, std::uint64_t chunk_count);

  /// The chunks for which `wanted` is true of their box and of the boxes around it; by id. Errors: pages
  /// that are missing or of another size; invalid boxes, or boxes not inside that of their page. Cost:
  /// the pages that are tested.
  std::vector<ChunkLocation> chunks(const std::function<bool(const Bounds&)>& wanted);

  /// The chunk of this id, if there is one. Errors: as chunks(). Cost: one page.
  std::optional<ChunkLocation> chunk(std::uint64_t id);

 private:
  std::vector<Bounds> read_page(int level, std::uint64_t page, const Bounds& around);
  void visit(int level, std::uint64_t page, const Bounds& around,
             const std::function<bool(const Bounds&)>& wanted, std::vector<ChunkLocation>& found);

  std::string file_, table_;
  std::vector<std::uint64_t> counts_;  ///< boxes of every level
  Statement page_;
};

/// The chunks of one cloud. Errors: SQLite's; chunks that are missing, too short or not in their box,
/// with their number.
class ChunkStore final : public ChunkSource {
 public:
  /// The arguments must outlive it.
  ChunkStore(sqlite3* database, const std::string& schema, const std::string& table,
             const CloudSchema& cloud);

  /// By id. Cost: as BoxTree::chunks().
  std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) override;
  std::shared_ptr<StoredChunk> read(const ChunkLocation& location) override;
  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) override;

 private:
  [[noreturn]] void reject(std::uint64_t chunk, std::string problem, std::string expected,
                           std::string found) const;

  std::string file_, table_;
  Lattice lattice_;
  BoxTree boxes_;
  Statement positions_, values_;
};

}  // namespace alidade::database
