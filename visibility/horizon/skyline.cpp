// SPDX-License-Identifier: MIT
#include "visibility/horizon/skyline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "camera/camera.h"
#include "camera/projection.h"
#include "geo/earth.h"

namespace alidade::visibility {
namespace {

/// Sends a line through every pixel, towards direction(x, y), some rows at once. Calls take(pixel, blocker)
/// with the first blocker of each line that is blocked.
template <class Direction, class Take>
void look_through(const Occluders& occluders, const SightEnd& eye, double max_distance, int width, int height,
                  int rows_at_once, const Progress& progress, const Direction& direction, const Take& take) {
  const auto columns = static_cast<std::size_t>(width), pixels = columns * static_cast<std::size_t>(height);
  std::vector<SightLine> lines;
  std::vector<std::optional<Blocker>> blockers;
  for (int begin = 0; begin < height; begin += rows_at_once) {
    const std::size_t first = static_cast<std::size_t>(begin) * columns;
    report(progress, first, pixels);
    lines.clear();
    for (int y = begin; y < std::min(begin + rows_at_once, height); ++y)
      for (int x = 0; x < width; ++x) lines.push_back(sight_ray(eye, direction(x, y), max_distance));
    blockers.assign(lines.size(), {});
    first_blockers(occluders, lines, blockers);
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (blockers[i]) take(first + i, *blockers[i]);
  }
  report(progress, pixels, pixels);
}

}  // namespace

image::Film depth_panorama(const Occluders& occluders, const SightEnd& eye, int width, int height,
                           double max_distance, const Progress& progress) {
  constexpr std::array k_layers_of_depth = {image::Layer::depth, image::Layer::distance, image::Layer::id};
  image::Film film(width, height, k_layers_of_depth);
  const camera::Projection projection(camera::panorama_camera(eye.position, width, height));
  constexpr std::size_t k_lines_at_once = 1 << 16;
  const auto columns = static_cast<std::size_t>(width);
  const int rows_at_once = static_cast<int>(std::max<std::size_t>(k_lines_at_once / columns, 1));
  look_through(
      occluders, eye, max_distance, width, height, rows_at_once, progress,
      [&](int x, int y) {
        return projection.ray({x + 0.5, y + 0.5})->direction;
      },
      [&](std::size_t pixel, const Blocker& blocker) {
        film.distance[pixel] = film.depth[pixel] = static_cast<float>(blocker.distance);
        if (!blocker.is_mesh()) film.id[pixel] = static_cast<std::uint32_t>(blocker.point_id + 1);
      });
  return film;
}

DepthStrip strip_around(std::span<const HorizonDirection> horizon, double azimuth_min, double azimuth_max,
                        double highest) {
  constexpr double k_room_above = 3.0, k_room_below = 8.0, k_round = 5.0, k_least_extent = 20.0;
  constexpr double k_pixels_per_degree = 4.0, k_rows_per_degree = 8.0;
  constexpr int k_least_width = 720, k_least_height = 320, k_most_height = 560;
  double low = 0.0, high = highest;
  for (const HorizonDirection& direction : horizon) {
    if (!direction.elevation) continue;
    low = std::min(low, *direction.elevation);
    high = std::max(high, *direction.elevation);
  }
  low = k_round * std::floor((low - k_room_below) / k_round);
  high = k_round * std::ceil((high + k_room_above) / k_round);
  low = std::max(std::min(low, high - k_least_extent), -90.0);
  high = std::min(high, 90.0);
  const auto pixels = [](double degrees, double per_degree) {
    return static_cast<int>(std::lround(degrees * per_degree));
  };
  DepthStrip strip;
  strip.azimuth_min = azimuth_min;
  strip.azimuth_max = azimuth_max;
  strip.elevation_min = low;
  strip.elevation_max = high;
  strip.width = std::max(pixels(azimuth_max - azimuth_min, k_pixels_per_degree), k_least_width);
  strip.height = std::clamp(pixels(high - low, k_rows_per_degree), k_least_height, k_most_height);
  return strip;
}

void fill_strip(const Occluders& occluders, const SightEnd& eye, double max_distance, DepthStrip& strip,
                const Progress& progress) {
  strip.distances.assign(static_cast<std::size_t>(strip.width) * static_cast<std::size_t>(strip.height),
                         std::numeric_limits<float>::infinity());
  constexpr int k_rows_at_once = 32;
  look_through(
      occluders, eye, max_distance, strip.width, strip.height, k_rows_at_once, progress,
      [&](int x, int y) {
        const double azimuth =
            strip.azimuth_min + (x + 0.5) / strip.width * (strip.azimuth_max - strip.azimuth_min);
        return geo::compass_direction(
            azimuth,
            strip.elevation_max - (y + 0.5) / strip.height * (strip.elevation_max - strip.elevation_min));
      },
      [&](std::size_t pixel, const Blocker& blocker) {
        strip.distances[pixel] = static_cast<float>(blocker.distance);
      });
}

}  // namespace alidade::visibility
