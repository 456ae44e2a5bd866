// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "database/sqlite/sql_tokens.h"

namespace alidade::database {

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

/// Whether a condition in WHERE or ON ends before this token.
bool ends_condition(const TokenList& tokens, std::size_t index);

}  // namespace alidade::database
