// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "visibility/observers.h"

namespace alidade {

/// Two ends of a sight line as somebody wrote them.
struct GivenPair {
  GivenObserver from, to;
  bool has_places = false;  ///< otherwise only the names are known
};

/// Reads pairs from CSV: a header with the names of the columns in any order, then a row each: `from` and
/// `to` are names; `from_x`, `from_y`, `to_x`, `to_y` places in the cloud's coordinates, `from_z` and `to_z`
/// what they stand on (empty: the ground), `from_height` and `to_height` how far above it they are. Either
/// the names or the places must be there. Blank lines are skipped. Errors, naming the line: an unknown or
/// repeated column; a place without its other coordinates; a cell that is no finite number; an empty name
/// where there is no place; too many or too few cells; no row at all.
std::vector<GivenPair> read_pair_table(const std::filesystem::path& path);

}  // namespace alidade
