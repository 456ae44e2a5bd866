// SPDX-License-Identifier: MIT
#pragma once

#include "database/postgres/cloud_limit.h"
#include "database/postgres/postgres_api.h"

namespace alidade {

// Numbers of the operators in the operator classes of the install script.
constexpr int k_keeps = 1;   ///< cloud_point <@ cloud_limit
constexpr int k_breaks = 2;  ///< cloud_point !<@ cloud_limit
constexpr int k_to_ray = 15;
constexpr int k_to_plane = 16;

/// False only if the condition of an index scan holds for no point of the box.
inline bool may_match(int symbol, Datum argument, const Bounds& box) {
  const auto& limit = value_of<CloudLimit>(argument);
  return guarded([&] { return symbol == k_keeps ? may_hold(limit, box) : may_break(limit, box); });
}

}  // namespace alidade
