// SPDX-License-Identifier: MIT
#include "camera/camera_set.h"

#include <cmath>

namespace alidade::camera {
namespace {

/// Limits of camera files (docs/cameras.md).
constexpr double k_least_focal_length = 1e-6, k_largest_focal_length = 1e12, k_farthest_middle = 1e9;

bool is_possible(const E57Picture& picture, const Camera& camera) {
  constexpr auto k_side = static_cast<std::uint64_t>(k_max_image_side);
  if (picture.width < 1 || picture.height < 1 || picture.width > k_side || picture.height > k_side)
    return false;
  if (picture.width * picture.height > k_max_pixels) return false;
  for (const double length : {camera.fx, camera.fy})
    if (!(length >= k_least_focal_length && length <= k_largest_focal_length)) return false;
  return std::abs(camera.cx) <= k_farthest_middle && std::abs(camera.cy) <= k_farthest_middle;
}

}  // namespace

std::optional<Camera> camera_of(const E57Image& image, const E57Picture& picture) {
  Camera camera;
  glm::dvec3 right(1, 0, 0), down(0, -1, 0), forward(0, 0, -1);
  if (picture.projection == E57Projection::pinhole) {
    camera.fx = picture.focal_length / picture.pixel_width;
    camera.fy = picture.focal_length / picture.pixel_height;
    camera.cx = picture.principal_x;
    camera.cy = picture.principal_y;
  } else if (picture.projection == E57Projection::spherical) {
    camera.lens = EquirectangularLens{};
    camera.fx = 1.0 / picture.pixel_width;
    camera.fy = 1.0 / picture.pixel_height;
    camera.cx = 0.5 * static_cast<double>(picture.width);
    camera.cy = 0.5 * static_cast<double>(picture.height);
    right = {0, -1, 0};
    down = {0, 0, -1};
    forward = {1, 0, 0};
  } else {
    return std::nullopt;
  }
  if (!is_possible(picture, camera)) return std::nullopt;
  camera.width = static_cast<int>(picture.width);
  camera.height = static_cast<int>(picture.height);
  const E57Pose pose = image.pose.value_or(E57Pose{});
  camera.pose = {.position = pose.translation,
                 .right = pose.rotation * right,
                 .down = pose.rotation * down,
                 .forward = pose.rotation * forward};
  return camera;
}

}  // namespace alidade::camera
