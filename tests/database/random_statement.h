// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "database/sqlite/sqlite_api.h"
#include "tests/support/random.h"

namespace alidade::test {

/// A SELECT over clouds `points` and `odd "cloud` and add_statement_tables(), with conditions on dist_ray and
/// dist_plane in many clauses and spellings. Some may be pruned and some not.
struct RandomStatement {
  std::string text;
  int parameters = 0;       ///< what to bind: numbers 1, 2, ...
  bool is_ordered = false;  ///< the statement says in which order the rows come
};

RandomStatement random_statement(Random& random);

/// Makes the tables and views that such statements have beside clouds.
void add_statement_tables(sqlite3* database);

struct StatementAnswer {
  std::vector<std::string> rows;  ///< sorted, unless the statement says in which order they come
  std::string error;              ///< then there are no rows
};

/// Binds numbers to the parameters of the statement and runs it.
StatementAnswer answer_of(sqlite3* database, sqlite3_stmt* statement, const RandomStatement& wanted);

}  // namespace alidade::test
