// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "renderer/integrator.h"

namespace alidade {

/// What the camera paths bring back in the mode that the settings ask for. results: as many as paths.
/// `ao_distance`: see ambient_occlusion_distance().
void trace_samples(const World& world, const Lights& lights, const RenderSettings& settings,
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results);

}  // namespace alidade
