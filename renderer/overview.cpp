// SPDX-License-Identifier: MIT
#include "renderer/overview.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "base/color.h"
#include "renderer/render.h"

namespace alidade::renderer {

Scene daylight_scene(std::vector<std::filesystem::path> files) {
  Scene scene;
  scene.sky = GradientSky{.horizon = {0.72f, 0.80f, 0.88f}, .zenith = {0.30f, 0.48f, 0.80f}};
  scene.sun = geo::Sun{.irradiance = {2.2f, 2.1f, 1.95f}};
  if (files.empty()) return scene;
  CloudSettings& cloud = scene.cloud.emplace();
  cloud.files = std::move(files);
  cloud.normals = NormalMode::smooth;
  cloud.shape = PointShape::blend;
  return scene;
}

namespace {

/// Whole degrees, by which the same image comes from every C library.
double rounded_angle(double y, double x) {
  return std::round(std::atan2(y, x) * 180.0 / std::numbers::pi);
}

/// The azimuth, in whole degrees, from the middle of the scanners to that of the points; empty if they are
/// close to each other, as with scanners all around.
std::optional<double> azimuth_from_scanners(std::span<const ScannerPosition> scanners, const Bounds& points) {
  constexpr double k_least_share = 0.25;  // of half the diagonal
  if (scanners.empty()) return std::nullopt;
  glm::dvec3 middle(0.0);
  for (const ScannerPosition& scanner : scanners)
    middle += scanner.position / static_cast<double>(scanners.size());
  const glm::dvec2 way = points.center() - middle, half = 0.5 * points.size();
  const double distance = glm::length(way);
  if (!std::isfinite(distance) || !(distance > k_least_share * glm::length(half))) return std::nullopt;
  return rounded_angle(way.x, way.y);
}

/// The frame of a depth camera as it saw it.
std::optional<camera::Camera> view_of_frame(std::span<const ScannerPosition> scanners,
                                            std::span<const glm::dvec3> positions, int width, int height) {
  if (scanners.size() != 1 || !scanners.front().axes) return std::nullopt;
  const auto& [forward, down] = *scanners.front().axes;
  return camera::filled_camera({.position = scanners.front().position,
                                .right = glm::cross(down, forward),
                                .down = down,
                                .forward = forward},
                               positions, width, height);
}

}  // namespace

camera::Camera overview_camera(const LoadedCloud& cloud, int width, int height) {
  // Most radii are smaller than the largest that the density allows, unless there are few points.
  constexpr std::size_t k_few = 2000;
  const bool is_dense = cloud.lone_radius > 0.0 && cloud.octree.size() > k_few;
  const double radius = is_dense ? 2.0 * cloud.lone_radius : cloud.radius;
  const std::vector<glm::dvec3> positions = visible_positions(cloud);
  if (const auto frame = view_of_frame(cloud.scanner_positions, positions, width, height)) return *frame;
  const auto azimuth = azimuth_from_scanners(cloud.scanner_positions, visible_bounds(cloud));
  return azimuth ? camera::overview_camera(positions, radius, width, height, *azimuth)
                 : camera::overview_camera(positions, radius, width, height);
}

void light_from_scanners(Scene& scene, const LoadedCloud& cloud, const camera::Camera& view) {
  const std::vector<ScannerPosition>& scanners = cloud.scanner_positions;
  const bool is_from_scanners =
      !scanners.empty() && (scanners.front().axes || azimuth_from_scanners(scanners, visible_bounds(cloud)));
  if (!is_from_scanners || !scene.sun) return;
  const camera::CameraPose& pose = view.pose;
  const glm::dvec3 sun = 0.5 * pose.right - 0.6 * pose.down - 0.6 * pose.forward;
  scene.sun->azimuth = rounded_angle(sun.x, sun.y);
  scene.sun->elevation = std::max(-89.0, rounded_angle(sun.z, std::hypot(sun.x, sun.y)));
}

double automatic_exposure(const Scene& scene, const LoadedCloud* cloud, const camera::Camera& view) {
  constexpr int k_longest_side = 96, k_samples = 4;
  // Source: sRGB (IEC 61966-2-1): weights of the primaries.
  constexpr Rgb k_weights(0.2126f, 0.7152f, 0.0722f);
  // 0.47 of white as displayed, linear.
  constexpr double k_medium = 0.187, k_most_stops = 4.0;
  Scene small = scene;
  const double share = std::min(1.0, static_cast<double>(k_longest_side) / std::max(view.width, view.height));
  small.camera = camera::resized(view, std::max(1, static_cast<int>(view.width * share)),
                                 std::max(1, static_cast<int>(view.height * share)));
  small.render.samples = k_samples;
  small.output.transparent = true;
  const image::Film film = render(small, cloud, {.layers = std::vector{image::Layer::color}});
  std::vector<float> luminances;
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel)
    if (film.alpha[pixel] >= 0.5f)
      luminances.push_back(glm::dot(film.color[pixel], k_weights) / film.alpha[pixel]);
  if (luminances.empty()) return 0.0;
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::nth_element(luminances.begin(), middle, luminances.end());
  if (!(*middle > 0.0f)) return 0.0;
  // Rounded to a hundredth of a stop: the difference is invisible, and the number short.
  const double stops = std::round(100.0 * std::log2(k_medium / *middle)) / 100.0;
  return std::clamp(stops, -k_most_stops, k_most_stops);
}

}  // namespace alidade::renderer
