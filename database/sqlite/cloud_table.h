// SPDX-License-Identifier: MIT
#pragma once

#include "database/sqlite/connection.h"

// The virtual tables of clouds.

namespace alidade::database {

/// Registers the module pointcloud with a connection:
///   CREATE VIRTUAL TABLE name USING pointcloud
/// makes the points in the tables name_* (database/sqlite/cloud_schema.h) rows of a table. Its columns are
/// id, x, y, z and those of name_column. Hidden columns are the arguments of the form name(ox, oy, oz, dx,
/// dy, dz), the distance dist from that ray and the position t along it, and _chunk, for in_chunk().
///
/// Chunks without points for which the conditions on x, y, z, dist, t and in_chunk() may hold are not read,
/// also if the conditions are between tables of a join. ORDER BY t or dist reads only the chunks of the rows
/// that are fetched. The tables are read-only. They can be renamed and dropped; one whose stored tables
/// cannot be read can only be replaced (StoreOptions::replace). A scan adds its counts to `reads`, unless
/// that is null, when it ends; `reads` must outlive the connection. Returns SQLite's code.
int add_cloud_table(sqlite3* database, ScanReads* reads = nullptr);

/// Registers the module alidade with a connection, for cloud files that are not loaded:
///   CREATE VIRTUAL TABLE temp.name USING alidade('site.laz')
/// The arguments are one or more names of files, folders and patterns (FileCloud,
/// database/file_cloud.h), as text of SQL, which are one cloud. Columns, and the conditions that skip
/// chunks, are those of a pointcloud table with the same points, and so are rows except for their order and
/// rowid. Files are opened when the table is made, and remain open until it is dropped or the connection is
/// closed. If a file has changed meanwhile, the next statement fails.
///
/// Such tables belong to one connection: they are in `temp`, or in a database in memory. They cannot be made
/// in a database file, and one in the schema of a file is not opened; one in a database in memory is
/// connected again only while its schema is trusted (SQLITE_DBCONFIG_TRUSTED_SCHEMA). Views and triggers
/// cannot use them, except temporary ones (SQLITE_VTAB_DIRECTONLY). So only files are read that a user's own
/// statement names. If `tables` is null, options have their defaults; otherwise it must outlive the
/// connection. Returns SQLite's code.
int add_file_tables(sqlite3* database, const FileTables* tables = nullptr);

}  // namespace alidade::database
