// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "database/point_filter.h"
#include "database/sql/sql_tokens.h"

// The conditions of WHERE and ON, as far as they concern dist_ray and dist_plane.

namespace alidade::database {

/// Conditions nested in more parentheses are not read.
inline constexpr int k_deepest_parentheses = 64;

/// A call of dist_ray or dist_plane.
struct DistanceCall {
  DistanceKind kind{};
  std::string function;                     ///< "dist_ray" or "dist_plane"
  std::vector<TokenRange> line;             ///< its six numbers, or point and normal of a plane
  std::array<TokenRange, 3> coordinates{};  ///< the columns x, y, z of one table
  TokenRange table;                         ///< their qualifier with its dot; may be empty
};

/// Whether a call of dist_ray or dist_plane begins at a token.
bool is_distance(const TokenList& tokens, std::size_t index);

/// Reads the call at a token. Returns why it cannot be used; empty if it can. Requires is_distance().
std::string read_call(const TokenList& tokens, std::size_t index, DistanceCall& call);

struct Condition {
  enum class Kind {
    any,       ///< parts between OR
    all,       ///< parts between AND
    distance,  ///< a comparison of a distance
    other
  };

  Kind kind = Kind::other;
  bool is_negated = false;         ///< whether NOT is before it
  bool is_whole = true;            ///< false: its parentheses have more than it
  TokenRange tokens{};             ///< with parentheses, without NOT
  std::vector<Condition> parts{};  ///< of `any` and `all`

  // Of `distance`:
  DistanceCall call{};
  TokenRange comparison{};                       ///< without parentheses
  std::optional<TokenRange> least{}, largest{};  ///< limits on the distance, inclusive or not

  std::string reason{};  ///< of `other`: why one on a distance cannot be used; empty if it is not one
};

/// Reads the conditions that begin at a token, up to one that does not belong to them. Requires
/// tokens.is_sound().
Condition read_conditions(const TokenList& tokens, std::size_t begin);

}  // namespace alidade::database
