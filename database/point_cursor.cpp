// SPDX-License-Identifier: MIT
#include "database/point_cursor.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace alidade::database {

PointCursor::PointCursor(ChunkSource& source, const CloudSchema& cloud, ScanFilter filter, RowOrder order)
    : source_(source), cloud_(cloud), filter_(std::move(filter.points)), order_(order) {
  for (const ChunkLocation& location : source_.chunks(filter_, filter.only_chunk)) {
    double least = 0.0;
    if (order_ != RowOrder::stored) {
      const RayReach reach = project(filter_.lines.front().ray, location.box);
      least = order_ == RowOrder::t ? reach.t.low : reach.distance.low;
      // NaN from overflow: unknown.
      if (!(least >= -std::numeric_limits<double>::max())) least = -std::numeric_limits<double>::infinity();
    }
    chunks_.push_back({least, location});
  }
  std::ranges::stable_sort(chunks_, {}, &Next::least);
  next();
}

std::optional<RayProjection> PointCursor::projection() const {
  if (filter_.lines.empty()) return std::nullopt;
  return project(filter_.lines.front().ray, position());
}

void PointCursor::next() {
  if (order_ == RowOrder::stored)
    next_stored();
  else
    next_in_order();
  if (chunk_ != nullptr) ++reads_.rows_given;
}

std::shared_ptr<StoredChunk> PointCursor::read_next() {
  std::shared_ptr<StoredChunk> chunk = source_.read(chunks_[next_chunk_++].location);
  ++reads_.chunks_read;
  reads_.points_read += chunk->positions.size();
  return chunk;
}

void PointCursor::next_stored() {
  if (chunk_ != nullptr) ++row_;
  while (true) {
    for (; chunk_ != nullptr && row_ < chunk_->positions.size(); ++row_) {
      if (holds(filter_, position())) return;
    }
    chunk_.reset();
    row_ = 0;
    if (next_chunk_ == chunks_.size()) return;
    chunk_ = read_next();
  }
}

void PointCursor::next_in_order() {
  while (next_chunk_ < chunks_.size() &&
         (found_.empty() || chunks_[next_chunk_].least <= found_.top().measure)) {
    const std::shared_ptr<StoredChunk> chunk = read_next();
    for (std::size_t row = 0; row < chunk->positions.size(); ++row) {
      const glm::dvec3 position = to_world(cloud_.lattice, chunk->positions[row]);
      if (holds(filter_, position))
        found_.push({measure(project(filter_.lines.front().ray, position)), chunk, row});
    }
  }
  chunk_.reset();
  if (found_.empty()) return;
  chunk_ = found_.top().chunk;
  row_ = found_.top().row;
  found_.pop();
}

}  // namespace alidade::database
