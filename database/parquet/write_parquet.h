// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "base/progress.h"
#include "cloud/read_cloud.h"
#include "database/point_stream.h"

namespace alidade::database {

struct ParquetOptions {
  std::uint32_t group_points = 65536;  ///< per row group, 1024 to 1048576
  bool geometry = false;               ///< also a column of WKB points and the metadata of GeoParquet 1.1
  bool overwrite = false;              ///< an existing file; otherwise it is an Error
  /// Bytes for points; those of a larger cloud are kept in a file without a name beside the output.
  std::uint64_t memory = std::uint64_t{1} << 30;
  /// A reference system as PROJJSON; empty if it cannot be converted.
  std::function<std::string(const Crs&)> projjson{};
  Progress progress{};  ///< in points, after all are read
};

/// Writes a cloud as an Apache Parquet file for engines such as DuckDB and DataFusion. Columns have the names
/// and values of the tables that store_cloud() makes, `id` being the row in the cloud's files; numbers keep
/// their types, and zeros lose their signs. Points follow a Morton curve in row groups, which have fewer
/// points than requested if these take more than 32 MiB. Each group has the least and greatest value of its
/// columns, so that engines skip groups that a condition excludes. The key `crs` of the metadata has the
/// reference system as PROJJSON, or else as WKT. The file is written completely or not at all. Its bytes
/// depend neither on memory nor on the number of threads.
///
/// Errors: options out of range; the file exists; it cannot be written; no space left; more than 2^32 - 1
/// points in memory; more metadata than the format holds (2^31 - 1 bytes). Cancelled. Memory: 36 bytes
/// per point beside the cloud.
void write_parquet(const std::filesystem::path& file, const PointCloud& cloud,
                   const ParquetOptions& options = {});

/// Writes a cloud of so many points that comes in pieces. Memory: two pieces, 36 bytes per point of one, and
/// two blocks of 1024 points for each piece. `facts`: its lattice, reference system and extra dimensions.
void write_parquet(const std::filesystem::path& file, const PointCloud& facts, std::uint64_t point_count,
                   const PointPieces& pieces, const ParquetOptions& options = {});

/// Writes cloud files, without all points in memory. Memory: ParquetOptions::memory, two blocks of 1024
/// points for each time that memory was full, at most some 300 MB for points in process, and that of
/// CloudReader::read().
StoredFiles write_parquet(const std::filesystem::path& file, const CloudInputs& inputs,
                          const ReadOptions& reading, const ParquetOptions& options = {});

}  // namespace alidade::database
