// SPDX-License-Identifier: MIT
#pragma once

#include "simulation/courtyard_parts.h"

namespace alidade::simulation::courtyard_parts {

/// Four wings round the yard, with gateway and arcade.
void add_buildings(Objects& objects);
/// Houses across the street and to both sides.
void add_neighbours(Objects& objects);

}  // namespace alidade::simulation::courtyard_parts
