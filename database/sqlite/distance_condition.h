// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "database/sqlite/sql_tokens.h"

namespace alidade::database {

/// Conditions below more parentheses are left as they are.
inline constexpr int k_deepest_parentheses = 64;

/// A condition on dist_ray or dist_plane in a statement, from one token to another.
struct DistanceCondition {
  TokenRange tokens;
  std::string function;         ///< "dist_ray" or "dist_plane"
  std::vector<TokenRange> ray;  ///< its six numbers, or point and normal of a plane
  TokenRange table;             ///< what is in front of x, y, z with the dot behind it; empty if nothing
  std::optional<TokenRange> least, largest;  ///< limits on the distance, inclusive or not
};

/// What was found where a condition may begin: a condition, or why one that is on dist_ray or
/// dist_plane cannot be used, or neither.
struct ConditionAnswer {
  std::optional<DistanceCondition> condition;
  std::string reason;
};

/// Whether a call of dist_ray or dist_plane begins there.
bool is_distance(const TokenList& tokens, std::size_t index);

/// Requires tokens that are sound.
ConditionAnswer read_condition(const TokenList& tokens, std::size_t begin);

/// Fills in function, ray and table from the call there. Why it cannot be used; empty if it can. Requires
/// is_distance().
std::string read_call(const TokenList& tokens, std::size_t index, DistanceCondition& condition);

/// Whether a condition in WHERE or ON ends before this token.
bool ends_condition(const TokenList& tokens, std::size_t index);

/// The end of the condition, whatever it is, that begins there. An AND that belongs to BETWEEN does not end it.
/// Requires tokens that are sound.
std::size_t end_of_condition(const TokenList& tokens, std::size_t begin);

}  // namespace alidade::database
