// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <queue>
#include <vector>

#include "database/sqlite/chunk_store.h"
#include "database/sqlite/scan_reads.h"
#include "octree/distance.h"

namespace alidade {

/// In which order rows come.
enum class RowOrder {
  stored,    ///< by chunk, within it along the Morton curve
  t,         ///< by the place on the line of the filter's first condition
  distance,  ///< by the distance to it
};

/// What a scan gives.
struct ScanFilter {
  PointFilter points{};  ///< the points for which it holds
  std::optional<std::uint64_t> only_chunk{};
};

/// One scan of a cloud: the points for which a filter holds. Chunks are read when their first point may come,
/// so that the nearest few cost little. Memory: a chunk, or in another order than stored all chunks read so
/// far. Errors: ChunkStore's.
class PointCursor {
 public:
  /// What it is given must outlive it. An order that is not `stored` needs a line in the filter.
  PointCursor(ChunkStore& store, const CloudSchema& cloud, ScanFilter filter, RowOrder order);

  bool at_end() const { return chunk_ == nullptr; }
  void next();

  // Of the point it is at.
  glm::dvec3 position() const { return to_world(cloud_.lattice, chunk_->positions[row_]); }
  StoredChunk& chunk() const { return *chunk_; }
  std::size_t row() const { return row_; }
  /// Where it lies on the first line of the filter; none without a line.
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
    ChunkPlace place;
  };

  void next_stored();
  void next_in_order();
  double measure(const RayProjection& at) const { return order_ == RowOrder::t ? at.t : at.distance; }
  std::shared_ptr<StoredChunk> read_next();

  ChunkStore& store_;
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

}  // namespace alidade
