// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/progress.h"
#include "cloud/read_cloud.h"
#include "database/point_stream.h"

namespace alidade::database {

struct StoreOptions {
  std::string table = "points";       ///< what SQL calls the cloud
  std::uint32_t chunk_points = 1024;  ///< per chunk, 1 to 65536
  bool replace = false;               ///< a table of that name, if it is a cloud; otherwise it is an Error
  /// Bytes for points; those of a larger cloud wait in a file without a name beside the database, which takes
  /// as much room there as their columns and 4 bytes per point.
  std::uint64_t memory = std::uint64_t{1} << 30;
  Progress progress{};  ///< in points, once all are read
};

/// Stores a cloud in an SQLite database, which is made if it is not there, as a table that the module
/// pointcloud reads (database/sqlite/cloud_schema.h): points along a Morton curve in chunks, all attributes,
/// ids as their rows were. The table is written completely or not at all, and so is a new file, also if the
/// program is killed: then a hidden file may remain beside it, whose name ends in .part and a number. The
/// bytes depend neither on memory nor on the number of threads.
///
/// Errors: options out of range; the table exists; the file is no database or cannot be written; more than
/// 2^32 - 1 chunks, or points in memory; no space left; SQLite's. Cancelled. Memory: 36 bytes per point at
/// the peak beside the cloud.
void store_cloud(const std::filesystem::path& database, const PointCloud& cloud,
                 const StoreOptions& options = {});

/// The same for cloud files (read_cloud()), whose points memory need not hold. Memory: StoreOptions::memory,
/// 48 bytes per chunk, two blocks of 1024 points for each time that memory was full, some 100 MB for what is
/// under way, and what CloudReader::read_in_pieces() says.
StoredFiles store_files(const std::filesystem::path& database, const CloudInputs& inputs,
                        const ReadOptions& reading, const StoreOptions& options = {});

}  // namespace alidade::database
