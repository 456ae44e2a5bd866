// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "database/chunk_source.h"
#include "octree/distance.h"

namespace alidade::database {

/// Counts of what scans of clouds have read.
struct ScanReads {
  std::uint64_t scans = 0;        ///< in a join, a table is scanned once for each row before it
  std::uint64_t chunks = 0;       ///< of the clouds, summed over the scans
  std::uint64_t chunks_read = 0;  ///< of these
  std::uint64_t points_read = 0;  ///< in these
  std::uint64_t rows_given = 0;   ///< points that were passed to SQLite

  ScanReads& operator+=(const ScanReads& other) {
    scans += other.scans;
    chunks += other.chunks;
    chunks_read += other.chunks_read;
    points_read += other.points_read;
    rows_given += other.rows_given;
    return *this;
  }
};

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

}  // namespace alidade::database
