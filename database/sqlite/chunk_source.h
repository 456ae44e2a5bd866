// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "cloud/lattice.h"
#include "database/point_filter.h"
#include "database/stored_column.h"

namespace alidade::database {

/// A chunk of a cloud and a box around its points.
struct ChunkLocation {
  std::uint64_t id = 0;
  Bounds box;
};

/// Points of a chunk, as a scan has read them.
struct StoredChunk {
  std::uint64_t id = 0;
  std::vector<LatticePosition> positions;
  std::vector<std::optional<std::vector<std::byte>>> blobs;  ///< those read so far
};

/// What scans of a table read: points in chunks, in a database (database/sqlite/chunk_store.h) or in files
/// (database/sqlite/file_cloud.h). Errors: what is read is damaged.
class ChunkSource {
 public:
  virtual ~ChunkSource() = default;

  /// Chunks that may have points for which the filter holds, in the order of unordered scans; of all, or the
  /// only one to look at. Cost: the boxes that it has to look at.
  virtual std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) = 0;

  virtual std::shared_ptr<StoredChunk> read(const ChunkLocation& location) = 0;

  /// The bytes of a point in the column's blob, which is read if it is not there yet.
  virtual const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) = 0;
};

}  // namespace alidade::database
