// SPDX-License-Identifier: MIT
#pragma once

#include "database/sqlite/connection.h"

struct sqlite3;

namespace alidade::database {

/// Gives a connection the virtual table module pointcloud: CREATE VIRTUAL TABLE name USING pointcloud makes
/// the points readable that are stored in the tables name_* (database/sqlite/cloud_schema.h), with the
/// columns
///   id, x, y, z and those of NAME_column
/// and hidden ones: the arguments ox, oy, oz, dx, dy, dz of the form name(ox, oy, oz, dx, dy, dz), dist and t
/// of that ray, and _chunk for in_chunk(). Conditions on x, y, z, dist, t and in_chunk(), also between tables
/// of a join, leave chunks unread that have no such point; ORDER BY t or dist reads only as far as rows are
/// taken. The tables cannot be written to. They can be renamed and dropped; one whose stored tables cannot be
/// read can only be replaced (StoreOptions::replace). What scans read is added to `reads` when they end, if
/// it is given; it must outlive the connection. Answers SQLite's code.
int add_cloud_table(sqlite3* database, ScanReads* reads = nullptr);

}  // namespace alidade::database
