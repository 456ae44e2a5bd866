// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <queue>
#include <span>
#include <string>
#include <vector>

#include "database/sqlite/chunk_source.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/connection.h"
#include "database/sqlite/sqlite_api.h"
#include "database/stored_column.h"
#include "octree/distance.h"

namespace alidade::database {

/// Order of the rows.
enum class RowOrder {
  stored,    ///< by chunk, within it along the Morton curve
  t,         ///< by t along the line of the filter's first condition
  distance,  ///< by the distance to it
};

/// The rows of a scan.
struct ScanFilter {
  PointFilter points{};  ///< the points for which it holds
  std::optional<std::uint64_t> only_chunk{};
};

/// One scan of a cloud: the points for which a filter holds. A chunk is not read before its first point may
/// be next, so that the nearest few points cost little. Memory: a chunk, or in another order than `stored`
/// all chunks read so far. Errors: those of the source.
class PointCursor {
 public:
  /// The arguments must outlive it. Requires a line in the filter unless the order is `stored`.
  PointCursor(ChunkSource& source, const CloudSchema& cloud, ScanFilter filter, RowOrder order);

  bool at_end() const { return chunk_ == nullptr; }
  void next();

  // Of the current point.
  glm::dvec3 position() const { return to_world(cloud_.lattice, chunk_->positions[row_]); }
  StoredChunk& chunk() const { return *chunk_; }
  std::size_t row() const { return row_; }
  /// Its projection on the first line of the filter; empty without a line.
  std::optional<RayProjection> projection() const;

  const ScanReads& reads() const { return reads_; }

 private:
  struct Found {
    double measure;
    std::shared_ptr<StoredChunk> chunk;
    std::size_t row;
    bool operator<(const Found& other) const {  // the queue gives the greatest first
      if (measure != other.measure) return measure > other.measure;
      return std::pair(chunk->id, row) > std::pair(other.chunk->id, other.row);
    }
  };
  struct Next {
    double least;  ///< of the measure of its points
    ChunkLocation location;
  };

  void next_stored();
  void next_in_order();
  double measure(const RayProjection& at) const { return order_ == RowOrder::t ? at.t : at.distance; }
  std::shared_ptr<StoredChunk> read_next();

  ChunkSource& source_;
  const CloudSchema& cloud_;
  PointFilter filter_;  ///< of points
  RowOrder order_;
  std::vector<Next> chunks_;  ///< those to read, in that order
  std::size_t next_chunk_ = 0;
  std::priority_queue<Found> found_;
  std::shared_ptr<StoredChunk> chunk_;
  std::size_t row_ = 0;
  ScanReads reads_;
};

// The plan of a scan of a cloud's table: the conditions that SQLite passes, and the filter that they make.

/// The columns of a cloud's table by their numbers: the first stored one (id), x, y, z, the other stored
/// ones; hidden ox, oy, oz, dx, dy, dz, _chunk, dist, t, under the names of line_column().
class TableColumns {
 public:
  enum class Kind { stored, axis, argument, chunk, distance, t };

  static constexpr int k_hidden = 9;

  /// `stored` must outlive it. Requires at least one.
  explicit TableColumns(const std::vector<StoredColumn>& stored) : stored_(stored) {}

  Kind kind(int column) const;
  const StoredColumn& stored(int column) const {
    return stored_[static_cast<std::size_t>(column == 0 ? 0 : column - 3)];
  }
  int axis(int column) const { return column - 1; }
  std::size_t argument(int column) const { return static_cast<std::size_t>(column - first_hidden()); }

  /// Number of columns.
  int size() const { return first_hidden() + k_hidden; }
  /// CREATE TABLE with all columns.
  std::string declaration() const;

 private:
  int first_hidden() const { return static_cast<int>(stored_.size()) + 3; }

  const std::vector<StoredColumn>& stored_;
};

/// The form with a ray, for messages.
inline constexpr const char* k_ray_form = "FROM TABLE(ox, oy, oz, dx, dy, dz)";

/// A row id is the number of a chunk and, in the lowest bits, of the row in it.
inline constexpr int k_row_bits = 20;

/// Origin and direction of the form table(ox, oy, oz, dx, dy, dz), if it was used.
using Arguments = std::optional<std::array<double, 6>>;

/// Chooses the plan of a scan (xBestIndex). Its text, idxStr, has the conditions, which plan_filter() reads;
/// its number, idxNum, is the RowOrder. If fewer than six arguments are given, they are conditions on columns
/// that only the form with a ray has. Returns SQLite's code: SQLITE_CONSTRAINT if arguments come from a table
/// that is read later. Errors: a number for _chunk beside a ray.
int choose_plan(const TableColumns& columns, std::uint64_t point_count, sqlite3_index_info& info);

/// The filter of a scan, and its arguments; empty if no row can be an answer. Limits are closed: SQLite
/// checks each row once more. Errors: arguments that are not a ray; a value that is not a limit for
/// in_chunk().
std::optional<ScanFilter> plan_filter(const char* plan, std::span<sqlite3_value* const> values,
                                      Arguments& arguments);

}  // namespace alidade::database
