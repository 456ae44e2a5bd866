// SPDX-License-Identifier: MIT
#pragma once

struct sqlite3;

namespace alidade {

/// Gives a connection the virtual table module pointcloud: CREATE VIRTUAL TABLE name USING pointcloud makes
/// the points readable that are stored in the tables name_* (database/sqlite/cloud_schema.h), with the
/// columns
///   id, x, y, z and those of NAME_column
/// and hidden ones: the arguments ox, oy, oz, dx, dy, dz of the form name(ox, oy, oz, dx, dy, dz), dist and t
/// of that ray, and _chunk for in_chunk(). Conditions on x, y, z, dist, t and in_chunk(), also between tables
/// of a join, leave chunks unread that have no such point; ORDER BY t or dist reads only as far as rows are
/// taken. The tables cannot be written to. Answers SQLite's code.
int add_cloud_table(sqlite3* database);

}  // namespace alidade
