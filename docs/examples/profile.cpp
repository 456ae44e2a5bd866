// SPDX-License-Identifier: MIT
// profile CLOUD: heights along a way through the scan, as CSV.
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const Bounds& box = octree.bounds();
  const glm::dvec3 middle = box.center();

  const Path way = make_path({{box.min.x, middle.y, middle.z}, middle, {middle.x, box.max.y, middle.z}});
  std::printf("t,height,beside,segment\n");
  for (const PathHit& hit : find(octree, way, {.radius = 0.5})) {
    std::printf("%.3f,%.3f,%.3f,%zu\n", hit.t, hit.position.z, hit.distance, hit.segment);
  }
}
