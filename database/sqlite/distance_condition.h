// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "database/sqlite/sql_tokens.h"

namespace alidade::database {

/// Conditions nested in more parentheses are not changed.
inline constexpr int k_deepest_parentheses = 64;

/// A condition on dist_ray or dist_plane in a statement, from one token to another.
struct DistanceCondition {
  TokenRange tokens;
  std::string function;                      ///< "dist_ray" or "dist_plane"
  std::vector<TokenRange> ray;               ///< its six numbers, or point and normal of a plane
  TokenRange table;                          ///< the qualifier of x, y, z with its dot; may be empty
  std::optional<TokenRange> least, largest;  ///< limits on the distance, inclusive or not
};

/// The result of read_condition(): a condition, or the reason why one on dist_ray or dist_plane cannot be
/// used, or neither.
struct ConditionAnswer {
  std::optional<DistanceCondition> condition;
  std::string reason;
};

/// Whether a call of dist_ray or dist_plane begins at a token.
bool is_distance(const TokenList& tokens, std::size_t index);

/// Reads the condition that begins at a token. Requires tokens.is_sound().
ConditionAnswer read_condition(const TokenList& tokens, std::size_t begin);

/// Sets function, ray and table from the call at a token. Returns why the call cannot be used; empty if it
/// can. Requires is_distance().
std::string read_call(const TokenList& tokens, std::size_t index, DistanceCondition& condition);

/// Whether a condition in WHERE or ON ends before this token.
bool ends_condition(const TokenList& tokens, std::size_t index);

/// The end of any condition that begins at a token. An AND that belongs to BETWEEN does not end it.
/// Requires tokens.is_sound().
std::size_t end_of_condition(const TokenList& tokens, std::size_t begin);

}  // namespace alidade::database
