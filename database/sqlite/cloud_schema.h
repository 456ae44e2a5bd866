// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "database/chunk_source.h"

struct sqlite3;

// A cloud in SQLite. A table NAME of the module pointcloud reads five ordinary tables:
//
//   NAME_cloud   one row: format version, lattice, counts, reference system, kind of GPS times
//   NAME_column  the columns (StoredColumn), in their order
//   NAME_chunk   positions of chunks of points in Morton order: 3 int32 lattice steps per point
//   NAME_value   the other values: blob `blob` of chunk `chunk` has the id blob * 2^32 + chunk
//   NAME_bounds  boxes of the chunks (database/sqlite/chunk_store.h)
//
// Numbers in blobs are little endian.

namespace alidade::database {

inline constexpr int k_cloud_table_version = 1;
/// What follows NAME_ in the names of these tables.
inline constexpr const char* k_cloud_table_parts[] = {"cloud", "column", "chunk", "value", "bounds"};
inline constexpr std::uint32_t k_most_chunk_points = 65536;

/// Makes the ordinary tables of `table`. Errors: SQLite's.
void create_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table,
                         const CloudSchema& cloud);

/// Reads the schema that create_cloud_tables() wrote. Errors: the tables are missing, are not a cloud's, of
/// another version, or have invalid values.
CloudSchema read_cloud_schema(sqlite3* database, const std::string& schema, const std::string& table);

/// Removes those of the tables that exist, or whatever else has their names.
void drop_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table);

/// Renames the tables to those of a cloud `name`. Errors: SQLite's.
void rename_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table,
                         const std::string& name);

/// "SCHEMA"."TABLE_PART", quoted.
std::string part_name(const std::string& schema, const std::string& table, const std::string& part);

/// The id of a value blob.
constexpr std::int64_t value_id(int blob, std::uint64_t chunk) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(blob) << 32 | chunk);
}

}  // namespace alidade::database
