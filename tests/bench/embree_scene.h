// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "tests/bench/bench_site.h"
#include "tests/support/embree_spheres.h"

namespace alidade::bench {

/// The site's points as Embree spheres of the site's radius, in the octree's order, which is Embree's best
/// case.
inline std::unique_ptr<test::EmbreeSpheres> embree_scene(const BenchSite& site) {
  return std::make_unique<test::EmbreeSpheres>(site.cloud, site.radius, site.octree.bounds().min,
                                               std::span(site.octree.view().ids, site.cloud.size()));
}

}  // namespace alidade::bench
