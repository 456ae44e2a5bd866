// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "cloud/crs.h"

namespace alidade {

/// What x and y of a cloud are counted in.
struct CloudUnit {
  std::string name{};              ///< "m", "ft", or empty if it is another one or not known
  std::optional<double> metres{};  ///< of one of them; empty if that is not known
};

/// Asks GDAL, which knows systems by their codes, and where it does not know one, the system's own words
/// (geo/map_unit.h). Requires: not degrees. Errors: those of load_module_function().
CloudUnit cloud_unit(const Crs& crs);

}  // namespace alidade
