// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "cloud/crs.h"

namespace alidade {

/// Longitude and latitude (degrees, WGS 84) of places in a reference system; z stays as it is. Rounded to
/// 1e-9 degrees (0.1 mm), so that every machine answers the same. Empty if the system is not known or lies
/// nowhere on Earth, or if one of the places does.
std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> places);

/// Length of a map's unit. Of a cloud that names no system, which is taken for metres, 1; empty for degrees
/// and for systems that GDAL does not know.
std::optional<double> metres_per_unit(const Crs& crs);

}  // namespace alidade
