// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "database/sqlite/sqlite_api.h"

namespace alidade {

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

/// A statement ready to run.
struct Prepared {
  StatementHandle statement{};  ///< empty if there were only blanks and comments
  std::size_t size = 0;         ///< bytes of the text that it took, with its semicolon
  std::string pruned{};  ///< what runs instead of the text (prune_statement.h); empty if it is as given
  std::string reason{};  ///< why it, or some condition in it, is as given; empty if there is none
};

/// Prepares the statement of a text that begins at that byte; where conditions on dist_ray and dist_plane can
/// leave chunks unread without changing the answer, such that they do. Rows, values, names of columns,
/// parameters and errors are those of the text, with these exceptions: rows whose order the text leaves open
/// may come in another one, and a condition that gives errors, but has no limit, is asked about other rows,
/// since SQLite may then ask the conditions of a statement in another order. One that calls random() or
/// randomblob(), a view included, is as given. Takes away an authorizer that the connection may have.
///
/// Errors: what SQLite does not understand, with `file` (what the text is called) and line and column in it.
Prepared prepare(sqlite3* database, std::string_view sql, std::size_t begin = 0,
                 const std::string& file = "statement");

}  // namespace alidade
