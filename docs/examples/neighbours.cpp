// SPDX-License-Identifier: MIT
// neighbours CLOUD: the points around one point, by number, by radius and by box.
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));

  const glm::dvec3 position = find(octree, octree.bounds().center(), {.k = 1}).at(0).position;
  for (const PointHit& hit : find(octree, position, {.k = 8})) {
    std::printf("point %llu is %.3f m away\n", static_cast<unsigned long long>(hit.point_id), hit.distance);
  }
  const Bounds room{position - 0.5, position + 0.5};
  std::printf("%zu points within 0.5 m, %zu in a box of 1 m\n", count(octree, position, {.radius = 0.5}),
              find(octree, room).size());
}
