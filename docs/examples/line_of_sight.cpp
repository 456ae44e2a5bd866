// SPDX-License-Identifier: MIT
// line_of_sight CLOUD: which share of the horizon is free, seen from above the middle of the scan?
#include <cmath>
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int count, char** arguments) {
  using namespace alidade;
  if (count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const glm::dvec3 eye = octree.bounds().center();

  std::vector<Ray> rays;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * std::acos(-1.0) / 180.0;
    rays.push_back(make_ray(eye, {std::cos(angle), std::sin(angle), 0.0}, 1.0, 1000.0));
  }
  std::vector<std::uint8_t> blocked(rays.size());
  occluded(octree, rays, {.radius = 0.05}, blocked);

  int free = 0;
  for (const std::uint8_t answer : blocked) free += answer == 0 ? 1 : 0;
  std::printf("%d of %zu directions are free\n", free, rays.size());
}
