// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "cloud/crs.h"

// What the module knows of reference systems (tools/load_module.h).

namespace alidade {

/// lon_lat() of geo/earth.h, into `answers`. Errors, here and below: those of
/// load_module_function().
using LonLatTransformer = void (*)(const Crs& crs, const std::vector<glm::dvec3>& places,
                                   std::optional<std::vector<glm::dvec3>>& answers);
LonLatTransformer load_lon_lat();

/// metres_per_unit() of geo/earth.h, into `metres`.
using UnitMeasure = void (*)(const Crs& crs, std::optional<double>& metres);
UnitMeasure load_metres_per_unit();

}  // namespace alidade
