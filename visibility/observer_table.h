// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "base/input_file.h"
#include "visibility/observers.h"

namespace alidade {

/// Reads observers from CSV: a header with the names of the columns in any order, then a row each. `x` and
/// `y` must be there; `z`, `name`, `height`, `azimuth_min`, `azimuth_max`, `elevation_min`, `elevation_max`
/// and `max_distance` may, also under the short names of observer_fields.h. An empty cell is as if it were
/// not there; blank lines are skipped. Errors, naming line and column: an unknown or repeated name, a missing
/// place, a cell that is no number, too many or too few cells; no row at all.
std::vector<GivenObserver> read_observer_table(const std::filesystem::path& path);
std::vector<GivenObserver> read_observer_table(InputFile& file);

}  // namespace alidade
