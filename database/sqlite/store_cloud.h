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
  std::string table = "points";       ///< name of the cloud in SQL
  std::uint32_t chunk_points = 1024;  ///< per chunk, 1 to 65536
  bool replace = false;               ///< a table of that name, if it is a cloud; otherwise it is an Error
  /// Bytes for points; those of a larger cloud are kept in a file without a name beside the database, which
  /// takes the size of their columns and 4 bytes per point.
  std::uint64_t memory = std::uint64_t{1} << 30;
  Progress progress{};  ///< in points, after all are read
};

/// Stores a cloud in an SQLite database, which is made if it does not exist, as a table that the module
/// pointcloud reads (database/sqlite/cloud_schema.h): points along a Morton curve in chunks, all attributes,
/// row numbers as ids. The table is written completely or not at all, and so is a new file, also if the
/// program is killed: then a hidden file may remain beside it, whose name ends in .part and a number. The
/// bytes depend neither on memory nor on the number of threads.
///
/// Errors: options out of range; the table exists; the file is not a database or cannot be written; more than
/// 2^32 - 1 chunks, or points in memory; no space left; SQLite's. Cancelled. Memory: 36 bytes per point at
/// the peak beside the cloud.
void store_cloud(const std::filesystem::path& database, const PointCloud& cloud,
                 const StoreOptions& options = {});

/// Stores cloud files (read_cloud()) as store_cloud() does, without all points in memory. Memory:
/// StoreOptions::memory, 48 bytes per chunk, two blocks of 1024 points for each time that memory was full,
/// some 100 MB for points in process, and that of CloudReader::read().
StoredFiles store_files(const std::filesystem::path& database, const CloudInputs& inputs,
                        const ReadOptions& reading, const StoreOptions& options = {});

}  // namespace alidade::database
