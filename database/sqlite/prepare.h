// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "database/sqlite/sqlite_api.h"

namespace alidade::database {

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

/// A statement ready to run.
struct Prepared {
  StatementHandle statement{};  ///< empty if there were only blanks and comments
  std::size_t size = 0;         ///< bytes of the statement in the text, with its semicolon
  /// The statement that runs instead (database/sql/rewrite_statement.h); empty if it was not changed.
  std::string pruned{};
  std::string reason{};  ///< why it, or some condition in it, was not changed; else empty
};

/// Prepares the statement that begins at byte `begin` of a text, such that conditions on dist_ray and
/// dist_plane skip chunks if that does not change the answer. Rows, values, names of columns, parameters and
/// errors are those of the text, with these exceptions: rows whose order the text leaves open may have
/// another order, and a condition that gives errors, but has no limit, may be evaluated on other rows, since
/// SQLite may evaluate the conditions of a statement in another order. A statement that calls random() or
/// randomblob(), also in a view, is not changed. Removes an authorizer that the connection may have.
///
/// Errors: those of SQLite's parser, with `file` (the name of the text) and line and column in it.
Prepared prepare(sqlite3* database, std::string_view sql, std::size_t begin = 0,
                 const std::string& file = "statement");

}  // namespace alidade::database
