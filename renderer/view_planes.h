// SPDX-License-Identifier: MIT
#pragma once

#include "octree/targets.h"
#include "renderer/scene.h"

namespace alidade {

/// Half-spaces that all have what a camera sees: nothing that lies outside one of them is in the picture.
/// Tight for pinholes and parallel rays; a little wider for other lenses, whose borders are bent. None if the
/// camera sees a right angle or more to one side of its axis.
HalfSpaces view_planes(const Camera& camera);

}  // namespace alidade
