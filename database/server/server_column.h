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

}  // namespace alidade
