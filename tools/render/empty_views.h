// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "image/color_key.h"
#include "tools/render/views.h"

namespace alidade::tools {

/// The views of a run that see no surface.
class EmptyViews {
 public:
  /// Keeps the view unless it has been seen to show something.
  void check(const View& view, bool sees_anything);

  /// ExitCode::no and a warning that names the views and guesses why, as 'alidade visibility photos' does; `done` if
  /// there is none, or the scene has no surface. `cloud` may be null.
  ExitCode report(const CameraRequest& request, const renderer::Scene& scene,
                  const renderer::LoadedCloud* cloud, Verbosity verbosity) const;

 private:
  std::vector<View> views_;
};

/// Names a coloring of a cloud by values that are all the same, which shows nothing; empty if it does.
std::string remark_on_colors(const image::ColorKey& key);

}  // namespace alidade::tools
