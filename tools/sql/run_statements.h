// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "database/sqlite/connection.h"
#include "tools/sql/sql_parameter.h"
#include "tools/sql/statements.h"

namespace alidade {

struct SqlRun {
  RowForm form = RowForm::table;
  bool explain = false;  ///< say what was read behind the rows of each statement, and whether it was pruned
  std::vector<SqlParameter> parameters{};
  bool are_all_used = true;  ///< whether a parameter that no statement has is an error
};

/// Runs all statements of a text, which `file` is called in messages, and prints their rows; not the first
/// one if a later one is wrong. Conditions on dist_ray and dist_plane leave chunks unread
/// (database/sqlite/prepare.h). Errors: a statement that does not only read, has a parameter without value,
/// or that SQLite does not understand; a parameter that no statement has; SQLite's. Cancelled, also while it
/// waits for who writes.
void run_statements(const Connection& connection, const std::string& text, const std::string& file,
                    SqlRun run);

}  // namespace alidade
