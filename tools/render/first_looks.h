// SPDX-License-Identifier: MIT
#pragma once

#include "tools/render/render_options.h"
#include "tools/render/views.h"

namespace alidade::tools {

/// Shows a picture in its preview file before its cloud is loaded, if the cloud consists of COPC files with
/// more than twice `preview_points` points: first with so many of them, then with eight times as many, and so
/// on up to half of them or 50 million. `view` is that of the picture, or null to show the whole cloud;
/// `scene` has its sky. Failures are no errors here: loading reports them. Errors: Cancelled.
void show_first_looks(const RenderCommand& command, const renderer::Scene& scene, const CloudInputs& clouds,
                      const View* view);

}  // namespace alidade::tools
