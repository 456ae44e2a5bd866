// SPDX-License-Identifier: MIT
// cross_section CLOUD: what lies in a slice of 10 cm through the scan, and in what a camera sees?
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const glm::dvec3 middle = octree.bounds().center();

  const HalfSpaces slice = make_slab(make_plane(middle, {1, 0, 0}), 0.1);
  const std::vector<PointHit> section = find(octree, slice);
  std::printf("%zu points in the slice\n", section.size());

  // A frustum of 90 degrees along x, from 1 m to 20 m: the first plane orders, here by depth.
  const HalfSpaces frustum{{make_plane(middle + glm::dvec3(1, 0, 0), {1, 0, 0}),
                            make_plane(middle + glm::dvec3(20, 0, 0), {-1, 0, 0}),
                            make_plane(middle, {1, 1, 0}), make_plane(middle, {1, -1, 0}),
                            make_plane(middle, {1, 0, 1}), make_plane(middle, {1, 0, -1})}};
  std::printf("%zu points in the frustum\n", count(octree, frustum));
}
