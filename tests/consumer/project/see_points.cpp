// SPDX-License-Identifier: MIT
#include <cstdio>

#include "octree/build.h"
#include "visibility/points/point_visibility.h"

int main() {
  // A square of ground with a roof above its eastern half.
  alidade::PointCloud cloud;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) {
      cloud.positions.emplace_back(100 * x, 100 * y, 0);
      if (x >= 10) cloud.positions.emplace_back(100 * x, 100 * y, 500);
    }
  }
  const alidade::visibility::Occluders occluders(alidade::build(cloud), {});
  alidade::visibility::Observer observer;
  observer.position = {1.5, 1.0, 3.0};
  const alidade::visibility::PointVisibility seen =
      alidade::visibility::point_visibility(occluders, std::span(&observer, 1), {});
  std::size_t count = 0;
  for (const std::uint32_t observers : seen.counts) count += observers;
  std::printf("%zu of %zu points are seen\n", count, seen.counts.size());
  return count > 150 && count < 450 ? 0 : 1;
}
