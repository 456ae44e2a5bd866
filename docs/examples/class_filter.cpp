// SPDX-License-Identifier: MIT
// class_filter CLOUD: which points off the ground come nearest to a line of sight, and how many come close?
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const PointCloud cloud = read_cloud(arguments[1]);
  const Octree octree = build(cloud);

  const Bounds& box = octree.bounds();
  const Ray sight = make_ray(box.min, box.max - box.min, 0.0);
  RayQuery query{.radius = 0.5, .measure = Measure::distance, .k = 5};
  query.filter = [&](const Candidate& point) {
    const std::uint8_t ground = 2;
    return cloud.classifications.empty() || cloud.classifications[point.point_id] != ground;
  };
  for (const Hit& hit : find(octree, sight, query)) {
    std::printf("%.3f m beside the line, %.3f m along it\n", hit.distance, hit.t);
  }
  query.k = k_all;
  std::printf("%zu such points within %.1f m\n", count(octree, sight, query), query.radius);
}
