// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

// SQLite shows a table only conditions on its columns, so it cannot prune by the paper's
//   SELECT * FROM points WHERE dist_ray(A, x,y,z) <= R
// as it stands. As
//   SELECT * FROM points WHERE (dist_ray(A, x,y,z) <= R AND in_chunk(_chunk, try_ray_limit(A, 0, R)))
// it can (database/sqlite/functions.h), and the rows are the same: in_chunk() is 1 for every point, or NULL
// where the condition is not true anyway.

namespace alidade {

struct PrunedStatement {
  std::string text;    ///< the statement with limits; empty if it was left as it is
  std::string reason;  ///< why it, or some condition in it, was left as it is; empty if there is none
};

/// Adds limits to the conditions on dist_ray and dist_plane of one statement that SQLite understands. They
/// may stand in WHERE and ON, below AND, OR, NOT and parentheses, as
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

}  // namespace alidade
