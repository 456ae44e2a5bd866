// SPDX-License-Identifier: MIT
#include <cstdio>

#include "octree/build.h"
#include "octree/query.h"

int main() {
  alidade::PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1000, 0, 0}, {2000, 5, 0}};
  const alidade::Octree octree = alidade::build(cloud);
  const alidade::Ray ray = alidade::make_ray({0.5, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.0);
  const auto hit = alidade::closest(octree, ray, {.radius = 0.01});
  if (!hit || hit->point_id != 1 || hit->t != 0.5) return 1;
  std::printf("point %llu at %g m\n", static_cast<unsigned long long>(hit->point_id), hit->t);
  return 0;
}
