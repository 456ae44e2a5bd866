// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include "simulation/finish.h"

namespace alidade {

/// What color_of() answers on terrain, before it is cut to 0 .. 1.
glm::dvec3 pavement_color(Pavement pavement, const glm::dvec3& position);

}  // namespace alidade
