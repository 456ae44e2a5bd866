// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <variant>

#include "base/error.h"
#include "base/parallel.h"
#include "visibility/photos/photo_frame.h"
#include "visibility/photos/photo_visibility.h"
#include "visibility/point_blocks.h"

namespace alidade::visibility {
namespace {

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
