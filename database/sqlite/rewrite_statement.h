// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/bounds.h"

// The paper's statement for engines without dist_ray: the distance as an expression, and additional
// conditions on x, y and z that such an engine pushes down to the statistics of its files or pages.

namespace alidade::database {

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
