// SPDX-License-Identifier: MIT
#include "camera/camera.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "base/exact_math.h"
#include "camera/projection.h"

namespace alidade::camera {
namespace {

/// The share of an image that an overview leaves empty on both sides together.
constexpr double k_margin = 0.04;

/// The vector with length 1; zero stays zero. It is scaled first, so that neither tiny vectors underflow nor
/// huge ones overflow.
glm::dvec3 unit(const glm::dvec3& v) {
  const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  return largest > 0.0 ? glm::normalize(v / largest) : v;
}

/// The smallest distance behind the centre from which all points lie within slopes of +-tangent on one film
/// axis.
double distance_to_fit(std::span<const double> across, std::span<const double> ahead, double tangent) {
  double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
  for (std::size_t i = 0; i < across.size(); ++i) {
    highest = std::max(highest, across[i] - tangent * ahead[i]);
    lowest = std::min(lowest, across[i] + tangent * ahead[i]);
  }
  return (highest - lowest) / (2.0 * tangent);
}

/// The sideways offset of a camera at this distance that gives equal margins on both sides of one film axis.
double offset_to_center(std::span<const double> across, std::span<const double> ahead, double distance) {
  double low = *std::min_element(across.begin(), across.end()),
         high = *std::max_element(across.begin(), across.end());
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (std::size_t i = 0; i < across.size(); ++i) {
      const double slope = (across[i] - middle) / (ahead[i] + distance);
      left = std::min(left, slope);
      right = std::max(right, slope);
    }
    (left + right > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Ray camera_ray(const Camera& camera, const glm::dvec2& film_position) {
  if (const std::optional<Ray> ray = Projection(camera).ray(film_position)) return *ray;
  throw Error({.problem = "the lens has no view at this film position"});
}

std::optional<glm::dvec2> project_to_film(const Camera& camera, const glm::dvec3& world) {
  return Projection(camera).project(world);
}

CameraPose look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up) {
  if (!is_finite(eye) || !is_finite(target) || !is_finite(up))
    throw Error({.problem = "look_at has a non-finite number"});
  const glm::dvec3 view = target - eye;
  if (view == glm::dvec3(0.0)) throw Error({.problem = "look_at: eye and target are equal"});
  if (up == glm::dvec3(0.0)) throw Error({.problem = "look_at: up is zero"});
  const glm::dvec3 forward = unit(view);
  const glm::dvec3 right = glm::cross(forward, unit(up));
  // Below this, rounding decides the direction of `right`.
  if (glm::dot(right, right) < 1e-20)
    throw Error({.problem = "look_at: up is parallel to the viewing direction"});
  CameraPose pose{.position = eye, .right = unit(right), .forward = forward};
  pose.down = unit(glm::cross(pose.forward, pose.right));
  return pose;
}

Camera pinhole_from_fov(int width, int height, double vertical_fov, const CameraPose& pose) {
  if (width < 1 || height < 1)
    throw Error({.problem = "image size out of range", .expected = "at least 1 x 1 pixels"});
  if (!(vertical_fov > 0.0 && vertical_fov < 180.0)) {
    throw input_error("vertical field of view out of range", "degrees between 0 and 180",
                      std::to_string(vertical_fov));
  }
  const SineCosine half = sine_cosine_of_degrees(0.5 * vertical_fov);
  const double focal_length = 0.5 * height / (half.sine / half.cosine);
  return {width, height, focal_length, focal_length, 0.5 * width, 0.5 * height, pose, PinholeLens{}};
}

Camera resized(const Camera& camera, int width, int height) {
  if (width < 1 || height < 1)
    throw Error({.problem = "image size out of range", .expected = "at least 1 x 1 pixels"});
  Camera result = camera;
  const double across = static_cast<double>(width) / camera.width;
  const double scale = static_cast<double>(height) / camera.height;
  result.width = width;
  result.height = height;
  // A panorama keeps its whole sphere; all others keep square pixels square.
  result.fx *= std::holds_alternative<EquirectangularLens>(camera.lens) ? across : scale;
  result.fy *= scale;
  result.cx *= across;
  result.cy *= scale;
  return result;
}

std::optional<Camera> filled_camera(const CameraPose& pose, std::span<const glm::dvec3> positions, int width,
                                    int height) {
  constexpr double k_steepest = 3.732;  // 75 degrees
  Bounds film;                          // at distance 1 before the camera
  for (const glm::dvec3& position : positions) {
    const glm::dvec3 way = position - pose.position;
    const double ahead = glm::dot(way, pose.forward);
    const glm::dvec3 slopes(glm::dot(way, pose.right) / ahead, glm::dot(way, pose.down) / ahead, 0.0);
    const bool is_seen =
        ahead > 0.0 && std::fabs(slopes.x) <= k_steepest && std::fabs(slopes.y) <= k_steepest;
    if (!is_seen) return std::nullopt;
    film.grow(slopes);
  }
  if (film.empty() || film.min == film.max) return std::nullopt;
  const glm::dvec3 size = film.size();
  const double focal_length = (1.0 - k_margin) * std::min(width / size.x, height / size.y);
  return Camera{.width = width,
                .height = height,
                .fx = focal_length,
                .fy = focal_length,
                .cx = 0.5 * width - focal_length * film.center().x,
                .cy = 0.5 * height - focal_length * film.center().y,
                .pose = pose,
                .lens = PinholeLens{}};
}

Camera overview_camera(const Bounds& bounds, int width, int height) {
  if (bounds.empty()) return overview_camera(std::span<const glm::dvec3>(), 0.0, width, height);
  return overview_camera(corners(bounds), 0.0, width, height);
}

Camera overview_camera(std::span<const glm::dvec3> positions, double radius, int width, int height,
                       double azimuth) {
  constexpr double k_vertical_fov = 40.0, k_descent = 30.0;
  Bounds bounds;
  for (const glm::dvec3& position : positions) bounds.grow(position);
  const glm::dvec3 center = bounds.empty() ? glm::dvec3(0.0) : bounds.center();
  const glm::dvec3 half = bounds.empty() ? glm::dvec3(0.0) : 0.5 * bounds.size();
  // A single point needs a margin that exceeds the rounding of its coordinates.
  const double magnitude = std::max({std::fabs(center.x), std::fabs(center.y), std::fabs(center.z)});
  const double least = glm::length(half) > 0.0 ? 1e-3 * glm::length(half) : std::max(0.02, 1e-9 * magnitude);
  const double room = std::max(radius, least);

  const SineCosine turn = sine_cosine_of_degrees(azimuth), descent = sine_cosine_of_degrees(k_descent);
  const glm::dvec3 forward(turn.sine * descent.cosine, turn.cosine * descent.cosine, -descent.sine);
  CameraPose pose = look_at(glm::dvec3(0.0), forward);
  Camera camera = pinhole_from_fov(width, height, k_vertical_fov, pose);

  // Offsets from the centre along the camera's axes, of each position and `room` to all sides of it.
  std::vector<double> right, down, ahead;
  const auto add = [&](const glm::dvec3& offset) {
    right.push_back(glm::dot(offset, pose.right));
    down.push_back(glm::dot(offset, pose.down));
    ahead.push_back(glm::dot(offset, pose.forward));
  };
  for (const glm::dvec3& position : positions) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 aside(0.0);
      aside[axis] = room;
      add(position - center + aside);
      add(position - center - aside);
    }
  }
  if (positions.empty()) add(glm::dvec3(0.0, 0.0, room)), add(glm::dvec3(0.0, 0.0, -room));
  const double distance = std::max(distance_to_fit(right, ahead, (1.0 - k_margin) * camera.cx / camera.fx),
                                   distance_to_fit(down, ahead, (1.0 - k_margin) * camera.cy / camera.fy));
  camera.pose.position = center + offset_to_center(right, ahead, distance) * pose.right +
                         offset_to_center(down, ahead, distance) * pose.down - distance * pose.forward;
  return camera;
}

Camera panorama_camera(const glm::dvec3& position, int width, int height) {
  if (width < 1 || height < 1)
    throw Error({.problem = "image size out of range", .expected = "at least 1 x 1 pixels"});
  return {.width = width,
          .height = height,
          .fx = width / (2.0 * std::numbers::pi),
          .fy = height / std::numbers::pi,
          .cx = 0.5 * width,
          .cy = 0.5 * height,
          .pose = {.position = position},
          .lens = EquirectangularLens{}};
}

Camera orthophoto_camera(const Bounds& bounds, double resolution) {
  if (!(resolution > 0.0) || !std::isfinite(resolution))
    throw input_error("resolution out of range", "a positive number of metres", std::to_string(resolution));
  if (bounds.empty()) throw Error({.problem = "the extent is empty"});
  const double left = std::floor(bounds.min.x / resolution), right = std::ceil(bounds.max.x / resolution);
  const double bottom = std::floor(bounds.min.y / resolution), top = std::ceil(bounds.max.y / resolution);
  const double width = std::max(right - left, 1.0), height = std::max(top - bottom, 1.0);
  if (!(width <= k_max_image_side && height <= k_max_image_side && width * height <= k_max_pixels)) {
    throw input_error("image too large",
                      "at most 65536 pixels in each direction and 2^28 in total: use a coarser "
                      "resolution or a smaller extent",
                      fmt::format("{:.0f} x {:.0f}", width, height));
  }
  Camera camera{.width = static_cast<int>(width),
                .height = static_cast<int>(height),
                .fx = 1.0 / resolution,
                .fy = 1.0 / resolution,
                .pose = {},
                .lens = OrthographicLens{}};
  // The camera's position is the image's upper left corner, so that its coordinates are those of the file.
  camera.pose = {.position = {left * resolution, (bottom + height) * resolution, bounds.max.z + resolution},
                 .right = {1.0, 0.0, 0.0},
                 .down = {0.0, -1.0, 0.0},
                 .forward = {0.0, 0.0, -1.0}};
  return camera;
}

double error_of_rotation(const glm::dmat3& rotation) {
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  double error = 0.0;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      const double difference = std::fabs(product[column][row] - (column == row ? 1.0 : 0.0));
      // NaN must not pass for a small difference.
      if (!(difference <= error)) error = difference;
    }
  }
  return error;
}

glm::dmat3 orthonormal(const glm::dmat3& rotation) {
  const glm::dvec3 z = unit_direction(rotation[2]);
  const glm::dvec3 x = unit_direction(glm::cross(rotation[1], z));
  return {x, glm::cross(z, x), z};
}

std::optional<glm::dmat3> rotation_from_quaternion(const std::array<double, 4>& quaternion) {
  double sum = 0.0;
  for (const double component : quaternion) sum += component * component;
  const double length = std::sqrt(sum);
  if (!(length >= 1e-100 && length <= 1e100)) return std::nullopt;
  const double w = quaternion[0] / length, x = quaternion[1] / length, y = quaternion[2] / length,
               z = quaternion[3] / length;
  // Columns: the images of the three axes (e.g. Shoemake, "Animating Rotation with Quaternion Curves", 1985).
  return glm::dmat3{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                    {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                    {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

glm::dmat3 rotation_from_axis_angle(const glm::dvec3& axis) {
  const double angle = length_of(axis);
  if (angle == 0.0) return glm::dmat3(1.0);
  const glm::dvec3 unit = unit_direction(axis);
  const SineCosine turn = sine_cosine(angle);
  glm::dmat3 rotation;
  for (int column = 0; column < 3; ++column) {
    glm::dvec3 base(0.0);
    base[column] = 1.0;
    rotation[column] =
        turn.cosine * base + turn.sine * glm::cross(unit, base) + (1.0 - turn.cosine) * unit[column] * unit;
  }
  return rotation;
}

CameraPose pose_from_world_to_camera(const glm::dmat3& rotation, const glm::dvec3& translation) {
  const glm::dmat3 axes = glm::transpose(rotation);
  return {.position = -(axes * translation), .right = axes[0], .down = axes[1], .forward = axes[2]};
}

std::array<double, 6> ground_transform(const Camera& camera) {
  const CameraPose& pose = camera.pose;
  if (!std::holds_alternative<OrthographicLens>(camera.lens) || !(pose.forward.z < -1.0 + 1e-12)) {
    throw input_error("a GeoTIFF requires an orthographic camera that looks down",
                      "--orthographic top, or an orthographic camera that looks along -z");
  }
  const glm::dvec3 across = pose.right / camera.fx, down = pose.down / camera.fy;
  const glm::dvec3 corner = pose.position - camera.cx * across - camera.cy * down;
  return {corner.x, across.x, down.x, corner.y, across.y, down.y};
}

}  // namespace alidade::camera
