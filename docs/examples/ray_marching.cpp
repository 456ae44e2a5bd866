// SPDX-License-Identifier: MIT
// ray_marching CLOUD: walks down a plumb line in steps as long as nothing can be in the way, and requests the
// same answer in one query.
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const Bounds& box = octree.bounds();
  const double radius = 0.25;
  const Ray ray = make_ray({box.center().x, box.center().y, box.max.z + 1.0}, {0, 0, -1}, 0.0, 100.0);

  // k = 1 from a centre that moves: its distance says how far the ray is free.
  double t = ray.t_min;
  int steps = 0;
  while (t <= ray.t_max) {
    const PointHit nearest = find(octree, ray.position(t), {.k = 1}).at(0);
    const double free = nearest.distance - radius;
    ++steps;
    if (free < 1e-6) {
      std::printf("marched to point %llu in %d steps: t = %.6f\n",
                  static_cast<unsigned long long>(nearest.point_id), steps, t);
      break;
    }
    t += free;
  }

  if (const std::optional<Hit> hit = closest(octree, ray, {.radius = radius})) {
    std::printf("closest is point %llu: entry = %.6f\n", static_cast<unsigned long long>(hit->point_id),
                hit->entry);
  }
}
