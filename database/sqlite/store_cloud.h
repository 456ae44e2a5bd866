// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/progress.h"
#include "database/point_stream.h"

namespace alidade::database {

struct StoreOptions {
  std::string table = "points";       ///< name of the cloud in SQL
  std::uint32_t chunk_points = 1024;  ///< per chunk, 1 to 65536
  bool replace = false;               ///< a table of that name, if it is a cloud; otherwise it is an Error
  Progress progress{};                ///< in points
};

/// Stores a cloud in an SQLite database, which is made if it does not exist, as a table that the module
/// pointcloud reads (database/sqlite/cloud_schema.h): points along a Morton curve in chunks, all attributes,
/// row numbers as ids. The table is written completely or not at all, and so is a new file, also if the
/// program is killed: then a hidden file may remain beside it, whose name ends in .part and a number. The
/// bytes depend neither on memory nor on the number of threads.
///
/// Errors: those of check_store(); the file cannot be written; more than 2^32 - 1 chunks; no space left;
/// SQLite's. Cancelled. Memory: 48 bytes per chunk, some 100 MB for points in process.
void store_cloud(const std::filesystem::path& database, OrderedCloud& cloud,
                 const StoreOptions& options = {});
void store_cloud(const std::filesystem::path& database, const PointCloud& cloud,
                 const StoreOptions& options = {});

/// Lets store_cloud() fail before points are read. Errors: options out of range; the table exists; the file
/// is not a database.
void check_store(const std::filesystem::path& database, const StoreOptions& options);

}  // namespace alidade::database
