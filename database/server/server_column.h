// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "database/stored_column.h"

// A cloud as a table of a PostgreSQL server: columns id, x, y, z, then the other stored ones.

namespace alidade {

/// How PostgreSQL keeps a column.
enum class ServerType { smallint, integer, bigint, real, double_precision, numeric, bytea };

/// The smallest type that holds all values of the column; ids are bigint.
ServerType server_type(const StoredColumn& column);

/// What stands between the brackets of CREATE TABLE, as produced by stored_columns().
std::string server_columns(const std::vector<StoredColumn>& columns);

/// The statement that makes the index which lets distances leave blocks of a table unread; the name is quoted
/// already.
std::string server_index(const std::string& quoted_name);

/// Errors: a name that is empty, longer than 40 bytes or has control characters. PostgreSQL keeps 63 bytes of
/// a name, and what belongs to a cloud has the table's name with something behind.
void check_server_table(const std::string& name);

/// Errors: more columns than PostgreSQL has room for, 1600 with x, y and z.
void check_column_count(const std::vector<StoredColumn>& columns);

}  // namespace alidade
