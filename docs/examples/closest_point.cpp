// SPDX-License-Identifier: MIT
// closest_point CLOUD: what does a plumb line through the middle of the scan meet first?
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int count, char** arguments) {
  using namespace alidade;
  if (count != 2) return 2;
  const PointCloud cloud = read_cloud(arguments[1]);
  const Octree octree = build(cloud);

  const Bounds& box = octree.bounds();
  const Ray ray = make_ray({box.center().x, box.center().y, box.max.z + 1.0}, {0, 0, -1}, 0.0);
  if (const std::optional<Hit> hit = closest(octree, ray, {.radius = 0.25})) {
    std::printf("point %llu: %.3f m below the start, %.3f m beside the line\n",
                static_cast<unsigned long long>(hit->point_id), hit->t, hit->distance);
  }
}
