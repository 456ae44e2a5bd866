// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "renderer/render.h"
#include "tools/render/render_options.h"

namespace alidade {

/// What the cameras of some views see of the scene's cloud, which lies in a database: points whose spheres,
/// as far as their radius is given, may be in a picture. `measuring` as in load_cloud(). Says how much was
/// read. Errors: the cloud is of another kind; no camera is given; layers that need the whole cloud; the
/// database's.
LoadedCloud load_in_view(const RenderCommand& command, const Scene& scene, std::span<const View> views,
                         const Progress& measuring);

}  // namespace alidade
