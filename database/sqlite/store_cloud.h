// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "octree/cloud/point_cloud.h"
#include "octree/progress.h"

namespace alidade {

struct StoreOptions {
  std::string table = "points";       ///< what SQL calls the cloud
  std::uint32_t chunk_points = 1024;  ///< per chunk, 1 to 65536
  bool replace = false;               ///< a table of that name, if it is a cloud; otherwise it is an Error
  Progress progress{};                ///< in points
};

/// Stores a cloud in an SQLite database, which is made if it is not there, as a table that the module
/// pointcloud reads (database/sqlite/cloud_schema.h): points along a Morton curve in chunks, all attributes,
/// ids as their rows were. The table is there as a whole or not at all, and so is a new file. The bytes do
/// not depend on the number of threads.
///
/// Errors: options out of range; the table exists; the file is no database or cannot be written; more than
/// 2^32 - 1 points or chunks; SQLite's. Cancelled. Memory: 36 bytes per point at the peak beside the cloud.
void store_cloud(const std::filesystem::path& database, const PointCloud& cloud,
                 const StoreOptions& options = {});

}  // namespace alidade
