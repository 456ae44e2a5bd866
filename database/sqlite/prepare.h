// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "database/sqlite/sqlite_api.h"

// SQLite passes only conditions on columns to a virtual table, so the paper's statement
//   SELECT * FROM points WHERE dist_ray(A, x,y,z) <= R
// cannot prune. Rewritten as
//   SELECT * FROM points WHERE (dist_ray(A, x,y,z) <= R AND in_chunk(_chunk, try_ray_limit(A, 0, R)))
// it can (database/sqlite/functions.h), and the rows are the same: in_chunk() is 1 for every point, or NULL
// if the condition is not true anyway.

namespace alidade::database {

struct PrunedStatement {
  std::string text;    ///< the statement with limits; empty if it was not changed
  std::string reason;  ///< why it, or some condition in it, was not changed; else empty
};

/// Adds limits to the conditions on dist_ray and dist_plane of one statement that SQLite understands. They
/// may be in WHERE and ON, below AND, OR, NOT and parentheses, as
///   dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) <= R    and with <, =, ==, >, >=, or with R in front
///   dist_ray(...) BETWEEN A AND B
/// with x, y, z columns of one table (p.x, p.y, p.z), and R a number, parameter, column or an expression in
/// parentheses.
///
/// Not changed, because the rows might change: a statement with more than one SELECT, with VALUES or WITH,
/// NATURAL, USING, RIGHT or FULL joins, or with both plain question marks and other parameters (plain ones
/// get numbers, since limits repeat them); a condition with function calls in its ray or R, which may return
/// another value each time; a condition in ON of LEFT JOIN on any but the joined table. Names are not
/// resolved: if SQLite finds no _chunk, or one of a view, the text is of no use.
PrunedStatement prune_statement(std::string_view sql);

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

/// A statement ready to run.
struct Prepared {
  StatementHandle statement{};  ///< empty if there were only blanks and comments
  std::size_t size = 0;         ///< bytes of the statement in the text, with its semicolon
  std::string pruned{};  ///< the statement that runs instead (prune_statement()); empty if it was not changed
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
