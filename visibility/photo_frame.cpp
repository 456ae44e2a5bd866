// SPDX-License-Identifier: MIT
#include "visibility/photo_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "visibility/point_blocks.h"

namespace alidade::visibility {
namespace {

/// Cosine of an angle to the axis that no direction in a frame exceeds, found along its edges; -2 if the lens
/// has no view through some of these, or one too wide for a cone to help.
double cosine_over_frame(const camera::Projection& projection) {
  constexpr int k_intervals = 32;
  constexpr double k_widest = 80.0 / 180.0 * std::numbers::pi, k_margin = 1.02, k_unbounded = -2.0;
  const camera::Camera& camera = projection.camera();
  double least = 1.0;
  for (int i = 0; i <= k_intervals; ++i) {
    const double x = camera.width * (static_cast<double>(i) / k_intervals);
    const double y = camera.height * (static_cast<double>(i) / k_intervals);
    for (const glm::dvec2& edge :
         {glm::dvec2(x, 0), glm::dvec2(x, camera.height), glm::dvec2(0, y), glm::dvec2(camera.width, y)}) {
      const std::optional<Ray> ray = projection.ray(edge);
      if (!ray) return k_unbounded;
      least = std::min(least, glm::dot(ray->direction, camera.pose.forward));
    }
  }
  const double angle = k_margin * std::acos(std::clamp(least, -1.0, 1.0)) + 1e-6;
  return angle < k_widest ? std::cos(angle) : k_unbounded;
}

/// Two unit vectors across a direction and each other.
std::pair<glm::dvec3, glm::dvec3> axes_across(const glm::dvec3& direction) {
  const glm::dvec3 other = std::fabs(direction.z) < 0.5 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 first = glm::normalize(glm::cross(direction, other));
  return {first, glm::cross(direction, first)};
}

/// Pixels per unit of length along `axis` at a position, by central differences.
std::optional<glm::dvec2> derivative(const camera::Projection& projection, const glm::dvec3& world,
                                     const glm::dvec3& axis, double step) {
  const std::optional<glm::dvec2> ahead = projection.project(world + step * axis);
  const std::optional<glm::dvec2> behind = projection.project(world - step * axis);
  if (!ahead || !behind) return std::nullopt;
  glm::dvec2 moved = *ahead - *behind;
  // A panorama has a seam behind the camera.
  const camera::Camera& camera = projection.camera();
  if (std::holds_alternative<camera::EquirectangularLens>(camera.lens))
    moved.x = std::remainder(moved.x, 2.0 * std::numbers::pi * camera.fx);
  return moved / (2.0 * step);
}

constexpr std::size_t k_points_checked = 1 << 17;

/// Whether any point is in the photo's frame and reach; every `every`-th point is tested.
bool shows_any(const PhotoFrame& frame, const std::vector<PlacedPoint>& points, std::size_t every,
               double max_distance) {
  std::atomic<bool> is_found = false;
  in_parallel((points.size() + every - 1) / every, 256, [&](std::size_t i) {
    if (is_found) return;
    const glm::dvec3& position = points[i * every].position;
    if (frame.film_position(position) && glm::length(position - frame.camera().pose.position) <= max_distance)
      is_found = true;
  });
  return is_found;
}

std::string box_text(const Bounds& box) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string low = fmt::format("{:.10g}", box.min[axis]),
                      high = fmt::format("{:.10g}", box.max[axis]);
    text +=
        fmt::format("{}{} {}", axis > 0 ? ", " : "", "xyz"[axis], low == high ? low : low + " to " + high);
  }
  return text;
}

/// Distance between the faces of two boxes; 0 if they overlap.
double gap_between(const Bounds& a, const Bounds& b) {
  return glm::length(glm::max(glm::max(a.min - b.max, b.min - a.max), glm::dvec3(0.0)));
}

/// Whether any point is in the frame and reach of any changed camera; every `every`-th point is tested.
template <class Change>
bool any_shows(const Octree& octree, std::span<const camera::NamedCamera> photos, std::size_t every,
               double max_distance, const Change& change) {
  const TreeView& tree = octree.view();
  for (const std::vector<Leaf>& batch : leaf_blocks(tree, k_points_checked)) {
    const std::vector<PlacedPoint> points = placed_points(tree, batch);
    for (const camera::NamedCamera& photo : photos)
      if (shows_any(PhotoFrame(change(photo.camera)), points, every, max_distance)) return true;
  }
  return false;
}

camera::Camera unchanged(const camera::Camera& camera) {
  return camera;
}

/// A camera with the y and z axes reversed.
camera::Camera turned_over(camera::Camera camera) {
  camera.pose.down = -camera.pose.down;
  camera.pose.forward = -camera.pose.forward;
  return camera;
}

/// A camera with the inverse pose.
camera::Camera inverted(camera::Camera camera) {
  const camera::CameraPose pose = camera.pose;
  camera.pose = {.position = {-glm::dot(pose.right, pose.position), -glm::dot(pose.down, pose.position),
                              -glm::dot(pose.forward, pose.position)},
                 .right = {pose.right.x, pose.down.x, pose.forward.x},
                 .down = {pose.right.y, pose.down.y, pose.forward.y},
                 .forward = {pose.right.z, pose.down.z, pose.forward.z}};
  return camera;
}

/// Why cameras far from a cloud may not see it, and the remedy; empty: they are not far.
std::string reason_of_distance(const Bounds& cameras, const Bounds& cloud) {
  const double far = 10.0 * glm::length(cloud.max - cloud.min) + 1000.0;
  if (gap_between(cameras, cloud) <= far) return "";
  const Bounds exchanged{{cameras.min.y, cameras.min.x, cameras.min.z},
                         {cameras.max.y, cameras.max.x, cameras.max.z}};
  if (gap_between(exchanged, cloud) <= far)
    return "cameras in the axes of the cloud: x and y of their positions are exchanged";
  const bool are_degrees =
      cameras.min.x >= -180.0 && cameras.max.x <= 180.0 && cameras.min.y >= -90.0 && cameras.max.y <= 90.0;
  if (are_degrees)
    return "cameras in the reference system of the cloud: their positions are degrees, or local coordinates "
           "of a reconstruction without georeference";
  return "cameras in the reference system of the cloud: theirs is another one";
}

std::string likely_reason(const Octree& octree, std::span<const camera::NamedCamera> photos,
                          const Bounds& cameras, double max_distance) {
  // Guesses need not be exact: some points of a large cloud will do.
  const std::size_t every = octree.size() / k_points_checked + 1;
  if (std::isfinite(max_distance) && any_shows(octree, photos, every, INFINITY, unchanged))
    return "a larger --max-distance";
  if (const std::string reason = reason_of_distance(cameras, octree.bounds()); !reason.empty()) return reason;
  if (any_shows(octree, photos, every, max_distance, turned_over))
    return "cameras that look at the cloud: they look away from it; are their axes those of OpenGL instead "
           "of OpenCV?";
  if (any_shows(octree, photos, every, max_distance, inverted))
    return "cameras that look at the cloud: the inverse of their poses do; are these from world to camera "
           "instead of from camera to world?";
  return "cameras that look at the cloud, in its reference system and scale";
}

}  // namespace

PhotoFrame::PhotoFrame(const camera::Camera& camera)
    : projection_(camera), least_cosine_(cosine_over_frame(projection_)) {}

std::optional<glm::dvec2> PhotoFrame::film_position(const glm::dvec3& world) const {
  const camera::Camera& camera = projection_.camera();
  // Most points of a large site are far outside of a photo, and the cone around the frame is quick to test.
  if (least_cosine_ >= 0.0) {
    const glm::dvec3 offset = world - camera.pose.position;
    const double ahead = glm::dot(offset, camera.pose.forward);
    if (ahead <= 0.0 || ahead * ahead < least_cosine_ * least_cosine_ * glm::dot(offset, offset))
      return std::nullopt;
  }
  const std::optional<glm::dvec2> film = projection_.project(world);
  if (!film || !(film->x >= 0.0 && film->x <= camera.width && film->y >= 0.0 && film->y <= camera.height))
    return std::nullopt;
  return film;
}

double PhotoFrame::ground_sampling_distance(const glm::dvec3& world, const PointSurface& surface) const {
  constexpr double k_step = 1e-3, k_none = std::numeric_limits<double>::infinity();
  const glm::dvec3 offset = world - projection_.camera().pose.position;
  const double distance = glm::length(offset);
  if (distance == 0.0) return k_none;
  const glm::dvec3 direction = offset / distance;
  const auto [first, second] = axes_across(direction);
  const std::optional<glm::dvec2> by_first = derivative(projection_, world, first, k_step * distance);
  const std::optional<glm::dvec2> by_second = derivative(projection_, world, second, k_step * distance);
  if (!by_first || !by_second) return k_none;
  const double across = std::fabs(by_first->x * by_second->y - by_first->y * by_second->x);
  const double sine =
      surface.exists ? std::max(k_least_view_sine, std::fabs(glm::dot(direction, surface.normal))) : 1.0;
  return 1.0 / std::sqrt(across * sine);
}

void check_photos(const Octree& octree, std::span<const camera::NamedCamera> photos, double max_distance) {
  if (photos.empty()) throw input_error("there is no photo", "at least one camera");
  Bounds cameras;
  for (const camera::NamedCamera& photo : photos) {
    if (std::holds_alternative<camera::OrthographicLens>(photo.camera.lens)) {
      throw input_error(fmt::format("camera '{}' is orthographic: it looks from no position", photo.name),
                        "cameras of photos");
    }
    cameras.grow(photo.camera.pose.position);
  }
  if (any_shows(octree, photos, 1, max_distance, unchanged)) return;
  throw input_error(
      "no point of the cloud is in the frame of any photo",
      likely_reason(octree, photos, cameras, max_distance),
      fmt::format("cameras at {}; a cloud at {}", box_text(cameras), box_text(octree.bounds())));
}

}  // namespace alidade::visibility
