// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "visibility/points/placement.h"
#include "visibility/row_files.h"

namespace alidade {

/// Writes the chosen places in their order, and with them the curve of what they cover: `place` from 1,
/// `candidate` (its number, from 0), `name`, `x`, `y`, `z` of the eye, `gain` and `covered` (weights of
/// targets, 1 each unless weighed), `share` (of all). CSV; JSON with the list `places`; or GeoJSON with
/// points, which other commands read as observers. Coordinates, answer and Errors as write_lines().
bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite);

}  // namespace alidade
