// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "database/sqlite/sql_tokens.h"

// The parts of SQL that all engines parse as SQLite does, for rewrite_statement.h.

namespace alidade::database {

/// Characters of operators in other dialects that SQLite does not have: casts, structs, powers.
inline constexpr std::string_view k_foreign_signs = ":{}^#!@";

/// Why other engines may cut a statement into other tokens than SQLite does, so that a condition may be part
/// of a text or comment; empty if they do not.
std::string foreign_tokens(std::string_view sql, const TokenList& tokens);

/// The value of a number with signs and parentheses; empty for other expressions, which
/// engines evaluate differently.
std::optional<double> constant(const TokenList& tokens, TokenRange range);

/// The shortest digits that are read as the same number, with an exponent: without one, several engines read
/// a literal as a decimal number.
std::string literal(double number);

/// dist_ray or dist_plane (octree/distance.h: project() and signed_distance()) in the same order of
/// operations, of the columns of these names. Lengths in the unit of the coordinates; `direction`: the ray's
/// or the normal, of length 1. Products with 0 are omitted: they do not change sums of finite numbers.
std::string distance_expression(bool is_ray, const std::array<std::string, 3>& coordinates,
                                const glm::dvec3& origin, const glm::dvec3& direction);

}  // namespace alidade::database
