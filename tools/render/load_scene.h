// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "renderer/render.h"
#include "tools/image_module.h"
#include "tools/render/render_options.h"
#include "tools/render/views.h"

namespace alidade::tools {

/// Shows a picture in its preview file before its cloud is loaded, if the cloud is made of COPC files with
/// more than twice `preview_points` points: first with so many of them, then with eight times as many, and so
/// on up to half of them or 50 million. `view` is that of the picture, or null if the whole cloud is to be
/// shown; `scene` has its sky. What cannot be shown in this way is no error: loading will tell. Errors:
/// Cancelled.
void show_first_looks(const RenderCommand& command, const renderer::Scene& scene, const CloudInputs& clouds,
                      const View* view);

/// What the cameras of some views see of the scene's cloud, which lies in a database: points whose spheres,
/// as far as their radius is given, may be in a picture. `measuring` as in load_cloud(). Says how much was
/// read. Errors: the cloud is of another kind; no camera is given; layers that need the whole cloud; the
/// database's.
renderer::LoadedCloud load_in_view(const RenderCommand& command, const renderer::Scene& scene,
                                   const CloudInputs& clouds, std::span<const View> views,
                                   const Progress& measuring);

}  // namespace alidade::tools
