// SPDX-License-Identifier: MIT
#include "visibility/photos/photo_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <variant>

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

}  // namespace alidade::visibility
