// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"
#include "database/point_filter.h"
#include "database/stored_column.h"

namespace alidade::database {

/// A cloud whose points are in chunks, as engines of SQL know it.
struct CloudSchema {
  Lattice lattice;
  std::uint64_t point_count = 0;
  std::uint64_t chunk_count = 0;
  Crs crs;
  bool gps_time_is_standard = false;  ///< PointCloud::gps_time_is_standard
  std::vector<StoredColumn> columns;
};

/// A chunk of a cloud and a box around its points.
struct ChunkLocation {
  std::uint64_t id = 0;
  Bounds box;
};

/// The points of a chunk that a scan has read.
struct StoredChunk {
  std::uint64_t id = 0;
  std::vector<LatticePosition> positions;
  std::vector<std::optional<std::vector<std::byte>>> blobs;  ///< those read so far
};

/// The source of scans of a table: points in chunks, in a database (database/sqlite/chunk_store.h) or in
/// files (database/file_cloud.h). Errors: damaged data.
class ChunkSource {
 public:
  virtual ~ChunkSource() = default;

  /// The chunks that may have points for which the filter holds, in the order of unordered scans; `only`: no
  /// other chunk is tested. Cost: the boxes that are tested.
  virtual std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) = 0;

  virtual std::shared_ptr<StoredChunk> read(const ChunkLocation& location) = 0;

  /// The bytes of a point in the column's blob, which is read at the first call.
  virtual const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) = 0;
};

}  // namespace alidade::database
