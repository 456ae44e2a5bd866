// SPDX-License-Identifier: MIT
#pragma once

#include "camera/camera.h"
#include "renderer/render.h"

namespace alidade::tools {

/// The exposure, in stops, that gives the surfaces in a view a medium brightness: half of their pixels are darker
/// than 0.47 of white as displayed, half brighter. It is that of a picture of 96 pixels, so that it is the same for
/// every part and size of a picture; within 4 stops of 0. 0 where the view has no surfaces. The scene's light is
/// prepared. Cost: that of the small picture.
double automatic_exposure(const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                          const camera::Camera& view);

}  // namespace alidade::tools
