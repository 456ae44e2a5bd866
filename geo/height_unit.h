// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "cloud/crs.h"

namespace alidade {

/// Unit of z, as far as the coordinate reference system tells: "m", "ft", or empty where it names another or
/// none. The vertical system counts, else the unit of the horizontal one; heights over degrees are metres,
/// and so are those of a cloud that says nothing at all.
std::string height_unit(const Crs& crs);

}  // namespace alidade
