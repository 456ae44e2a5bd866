// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "base/progress.h"
#include "database/point_stream.h"

namespace alidade::database {

struct ParquetOptions {
  std::uint32_t group_points = 65536;  ///< per row group, 1024 to 1048576
  bool geometry = false;               ///< also a column of WKB points and the metadata of GeoParquet 1.1
  bool overwrite = false;              ///< an existing file; otherwise it is an Error
  /// A reference system as PROJJSON; empty if it cannot be converted.
  std::function<std::string(const Crs&)> projjson{};
  Progress progress{};  ///< in points
};

/// Writes a cloud as an Apache Parquet file for engines such as DuckDB and DataFusion. Columns have the names
/// and values of the tables that store_cloud() makes, `id` being the row in the cloud's files; numbers keep
/// their types, and zeros lose their signs. Points follow a Morton curve in row groups, which have fewer
/// points than requested if these take more than 32 MiB. Each group has the least and greatest value of its
/// columns, so that engines skip groups that a condition excludes. The key `crs` of the metadata has the
/// reference system as PROJJSON, or else as WKT. The file is written completely or not at all. Its bytes
/// depend neither on memory nor on the number of threads.
///
/// Errors: options out of range; the file exists; it cannot be written; no space left; more metadata than the
/// format holds (2^31 - 1 bytes). Cancelled. Memory: at most some 300 MB for points in process.
void write_parquet(const std::filesystem::path& file, OrderedCloud& cloud,
                   const ParquetOptions& options = {});

}  // namespace alidade::database
