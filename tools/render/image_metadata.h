// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/image_metadata.h"
#include "tools/render/views.h"

namespace alidade::tools {

/// The metadata of a picture or depth map of a scene. `cloud` may be null; `words` is the command line.
renderer::ImageMetadata image_metadata(const renderer::Scene& scene, const View& view,
                                       const renderer::LoadedCloud* cloud, const CommandLine& words);

}  // namespace alidade::tools
