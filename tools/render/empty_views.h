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
  /// Keeps the view unless it sees anything.
  void check(const View& view, bool sees_anything);

  /// Returns ExitCode::no and warns of the views, with a probable reason, as 'alidade visibility photos'
  /// does; returns `done` if there are none, or the scene has no surface. `cloud` may be null.
  ExitCode report(const CameraRequest& request, const renderer::Scene& scene,
                  const renderer::LoadedCloud* cloud, Verbosity verbosity) const;

 private:
  std::vector<View> views_;
};

/// A warning if all values that a cloud is coloured by are equal; empty if they differ.
std::string remark_on_colors(const image::ColorKey& key);

}  // namespace alidade::tools
