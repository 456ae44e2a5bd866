// SPDX-License-Identifier: MIT
#include "visibility/occluders.h"

#include <cmath>
#include <string>

#include "base/error.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade {

Occluders::Occluders(const Octree& octree, const OccluderOptions& options, const Progress& progress)
    : octree_(octree), options_(options) {
  constexpr double k_widest_disc = 16.0;
  if (options.radius && !(std::isfinite(*options.radius) && *options.radius > 0.0)) {
    throw Error({.problem = "bad radius of occluders",
                 .expected = "a length above 0",
                 .found = std::to_string(*options.radius)});
  }
  if (options.transparency < 1) {
    throw Error({.problem = "bad transparency",
                 .expected = "1 or more crossings that block",
                 .found = std::to_string(options.transparency)});
  }
  if (has_surfaces() || !options.radius) {
    // Spacings of other neighbours make other discs.
    octree_ = with_spacings(octree_, k_surface_neighbours, progress);
  }
  if (has_surfaces()) octree_ = with_surfaces(octree_, progress);
  if (options.radius) {
    largest_radius_ = largest_sphere_ = *options.radius;
  } else {
    largest_sphere_ = automatic_radius(octree_);
    largest_radius_ = has_surfaces() ? k_widest_disc * largest_sphere_ : largest_sphere_;
  }
}

}  // namespace alidade
