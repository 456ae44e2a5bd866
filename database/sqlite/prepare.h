// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "database/sqlite/sqlite_api.h"

// SQLite shows a table only conditions on its columns, so it cannot prune by the paper's
//   SELECT * FROM points WHERE dist_ray(A, x,y,z) <= R
// as it stands. As
//   SELECT * FROM points WHERE (dist_ray(A, x,y,z) <= R AND in_chunk(_chunk, try_ray_limit(A, 0, R)))
// it can (database/sqlite/functions.h), and the rows are the same: in_chunk() is 1 for every point, or NULL
// where the condition is not true anyway.

namespace alidade::database {

struct PrunedStatement {
  std::string text;    ///< the statement with limits; empty if it was left as it is
  std::string reason;  ///< why it, or some condition in it, was left as it is; empty if there is none
};

/// Adds limits to the conditions on dist_ray and dist_plane of one statement that SQLite understands. They
/// may be in WHERE and ON, below AND, OR, NOT and parentheses, as
///   dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) <= R    and with <, =, ==, >, >=, or with R in front
///   dist_ray(...) BETWEEN A AND B
/// with x, y, z columns of one table (p.x, p.y, p.z), R a number, parameter, column or something in
/// parentheses.
///
/// Left as it is, because the rows might not stay the same: a statement with more than one SELECT, with
/// VALUES or WITH, NATURAL, USING, RIGHT or FULL joins, or parameters of which only some are plain question
/// marks (plain ones get numbers, since limits repeat them); a condition with function calls in its ray or R,
/// which may answer something else each time; a condition in ON of LEFT JOIN on any but the joined table.
/// Names are not looked up: if SQLite finds no _chunk, or one of a view, the text is of no use.
PrunedStatement prune_statement(std::string_view sql);

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

/// A statement ready to run.
struct Prepared {
  StatementHandle statement{};  ///< empty if there were only blanks and comments
  std::size_t size = 0;         ///< bytes of the text that it took, with its semicolon
  std::string pruned{};  ///< what runs instead of the text (rewrite_statement.h); empty if it is as given
  std::string reason{};  ///< why it, or some condition in it, is as given; empty if there is none
};

/// Prepares the statement of a text that begins at that byte; where conditions on dist_ray and dist_plane can
/// leave chunks unread without changing the answer, such that they do. Rows, values, names of columns,
/// parameters and errors are those of the text, with these exceptions: rows whose order the text leaves open
/// may come in another one, and a condition that gives errors, but has no limit, is evaluated on other rows,
/// since SQLite may then ask the conditions of a statement in another order. One that calls random() or
/// randomblob(), a view included, is as given. Takes away an authorizer that the connection may have.
///
/// Errors: what SQLite does not understand, with `file` (what the text is called) and line and column in it.
Prepared prepare(sqlite3* database, std::string_view sql, std::size_t begin = 0,
                 const std::string& file = "statement");

}  // namespace alidade::database
