// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/bounds.h"

namespace alidade::database {

// SQLite passes only conditions on columns to a virtual table, so the paper's statement
//   SELECT * FROM points WHERE dist_ray(A, x,y,z) <= R
// cannot prune. Rewritten as
//   SELECT * FROM points WHERE (dist_ray(A, x,y,z) <= R AND in_chunk(_chunk, try_ray_limit(A, 0, R)))
// it can (database/sqlite/functions.h), and the rows are the same: in_chunk() is 1 for every point, or NULL
// if the condition is not true anyway.

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

// The paper's statement for engines without dist_ray: the distance as an expression, and additional
// conditions on x, y and z that such an engine pushes down to the statistics of its files or pages.

/// The SQL of the rewritten statement, and the form in which several boxes reach the engine's statistics.
enum class SqlDialect {
  datafusion,  ///< OR of boxes
  duckdb,      ///< UNION ALL of one scan per box: its scans take conditions on single columns alone
  postgres,    ///< OR of boxes
  spark,       ///< OR of boxes
  sqlite,      ///< OR of boxes
  trino        ///< UNION ALL, as duckdb
};

struct RewriteOptions {
  SqlDialect dialect = SqlDialect::duckdb;
  /// Bounds of all points of the table, required since rays have no end. If empty, no conditions on boxes are
  /// added.
  std::optional<Bounds> bounds{};
  std::size_t box_count = 8;  ///< at most, 1 or more
};

struct RewrittenStatement {
  std::string text;
  std::string reason{};       ///< why it, or part of it, has no conditions on boxes; empty if there is none
  std::size_t box_count = 0;  ///< boxes whose conditions were added
  double share = 1.0;         ///< of the bounds' volume that they cover; 1 without boxes
};

/// Rewrites one statement. Every dist_ray(A, x,y,z) and dist_plane(A, x,y,z) becomes an expression with the
/// same value to the last bit in double precision, except for the sign of zero; x, y, z are columns of that
/// type. Conditions on them with constant limits, below AND, OR and parentheses in WHERE of one SELECT from
/// one table, prune by boxes (box_cover.h); other parts of WHERE do not prune and are kept.
///
/// The rows are those of the statement if all points of the table are within options.bounds. Constants are
/// numbers with signs and parentheses, since results of expressions differ between engines. Errors: A is not
/// six constants, such as columns of another table; A is not a ray or plane; the last arguments are not the
/// columns x, y, z of one table; a quoted column "X"; invalid tokens, or text that engines cut into different
/// tokens (backslashes in texts, dollar quotes, nested comments).
RewrittenStatement rewrite_statement(std::string_view sql, const RewriteOptions& options);

}  // namespace alidade::database
