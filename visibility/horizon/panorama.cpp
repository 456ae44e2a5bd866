// SPDX-License-Identifier: MIT
#include "visibility/horizon/panorama.h"

#include <algorithm>
#include <array>
#include <vector>

#include "camera/camera.h"
#include "camera/projection.h"

namespace alidade {

Film depth_panorama(const Occluders& occluders, const SightEnd& eye, int width, int height,
                    double max_distance, const Progress& progress) {
  constexpr std::array k_layers_of_depth = {Layer::depth, Layer::distance, Layer::id};
  Film film(width, height, k_layers_of_depth);
  const Projection projection(panorama_camera(eye.position, width, height));
  constexpr std::size_t k_lines_at_once = 1 << 16;
  const auto columns = static_cast<std::size_t>(width);
  const int rows_at_once = static_cast<int>(std::max<std::size_t>(k_lines_at_once / columns, 1));
  std::vector<SightLine> lines;
  std::vector<std::optional<Blocker>> blockers;
  for (int begin = 0; begin < height; begin += rows_at_once) {
    report(progress, film.index(0, begin), film.count());
    lines.clear();
    for (int y = begin; y < std::min(begin + rows_at_once, height); ++y) {
      for (int x = 0; x < width; ++x)
        lines.push_back(sight_ray(eye, projection.ray({x + 0.5, y + 0.5})->direction, max_distance));
    }
    blockers.assign(lines.size(), {});
    first_blockers(occluders, lines, blockers);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!blockers[i]) continue;
      const std::size_t pixel = film.index(0, begin) + i;
      film.distance[pixel] = film.depth[pixel] = static_cast<float>(blockers[i]->distance);
      film.id[pixel] = static_cast<std::uint32_t>(blockers[i]->point_id + 1);
    }
  }
  report(progress, film.count(), film.count());
  return film;
}

}  // namespace alidade
