// SPDX-License-Identifier: MIT
// preview CLOUD: the same ray asked of ever finer levels of a layered octree.
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  BuildOptions options;
  options.organisation = Organisation::layered;
  const Octree octree = build(read_cloud(arguments[1]), options);
  const Bounds& box = octree.bounds();
  const Ray ray = make_ray(box.min, box.max - box.min);
  for (int level = 0; level < octree.view().level_count; ++level) {
    const RayQuery query{.radius = 1.0, .max_level = level};
    std::printf("levels 0 to %d: %zu points near the ray\n", level, count(octree, ray, query));
  }
}
