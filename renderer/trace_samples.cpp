// SPDX-License-Identifier: MIT
#include "renderer/trace_samples.h"

#include "renderer/render_modes.h"

namespace alidade {

void trace_samples(const World& world, const Lights& lights, const RenderSettings& settings,
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results) {
  switch (settings.mode) {
    case RenderMode::path:
      return trace_paths(world, lights, paths, settings.max_bounces, results);
    case RenderMode::ambient_occlusion:
      return trace_ambient_occlusion(world, lights.sky(), ao_distance, paths, results);
    case RenderMode::headlight:
      return trace_headlight(world, lights.sky(), paths, results);
    case RenderMode::flat:
      return trace_flat(world, paths, results);
  }
}

}  // namespace alidade
