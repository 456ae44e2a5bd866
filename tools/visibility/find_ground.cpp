// SPDX-License-Identifier: MIT
#include "tools/visibility/find_ground.h"

#include <utility>

namespace alidade {

Ground find_ground(const VisibilityCloud& cloud, GroundOptions options, Verbosity verbosity) {
  ProgressLine line("finding the ground", "points", verbosity);
  options.progress = line.callback();
  Ground ground = make_ground(cloud.octree(), cloud.columns.classifications, options);
  line.finish();
  return ground;
}

}  // namespace alidade
