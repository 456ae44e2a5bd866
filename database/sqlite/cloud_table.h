// SPDX-License-Identifier: MIT
#pragma once

#include "database/sqlite/connection.h"

// The virtual tables of clouds.

namespace alidade::database {

/// Registers with a connection the virtual table module pointcloud: CREATE VIRTUAL TABLE name
/// USING pointcloud gives access to the points in the tables name_*
/// (database/sqlite/cloud_schema.h), with the columns
///   id, x, y, z and those of NAME_column
/// and hidden ones: the arguments ox, oy, oz, dx, dy, dz of the form name(ox, oy, oz, dx, dy, dz), dist and t
/// of that ray, and _chunk for in_chunk(). With conditions on x, y, z, dist, t and in_chunk(), also between
/// tables of a join, chunks without such points are not read; ORDER BY t or dist reads only the chunks of the
/// rows that are fetched. The tables are read-only. They can be renamed and dropped; one whose stored tables
/// cannot be read can only be replaced (StoreOptions::replace). Scans add their counts to `reads` when they
/// end, if it is given; it must outlive the connection. Returns SQLite's code.
int add_cloud_table(sqlite3* database, ScanReads* reads = nullptr);

/// Registers with a connection the virtual table module alidade, for cloud files that are not loaded:
///   CREATE VIRTUAL TABLE temp.name USING alidade('site.laz')
/// with one or more names of files, folders and patterns (FileCloud, database/sqlite/file_cloud.h) as SQL
/// text, which are one cloud. Columns, and the conditions that skip chunks, are those of a pointcloud table
/// into which the files are loaded, and so are rows except for their order and rowid. Files are opened when
/// the table is made, and remain open until it is dropped or the connection is closed; a file that has
/// changed since then is an error of the next statement.
///
/// Such tables belong to one connection: they are in `temp`, or in a database in memory. They cannot be
/// made in a database file, and one in the schema of a file is not opened; one in a database in memory
/// is connected again only while its schema is trusted (SQLITE_DBCONFIG_TRUSTED_SCHEMA). Views and
/// triggers cannot use them, except temporary ones (SQLITE_VTAB_DIRECTONLY). So only files are read that
/// a user's own statement names. Null `tables`: the default options; otherwise it must outlive the
/// connection. Returns SQLite's code.
int add_file_tables(sqlite3* database, const FileTables* tables = nullptr);

}  // namespace alidade::database
