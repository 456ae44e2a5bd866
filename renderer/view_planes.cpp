// SPDX-License-Identifier: MIT
#include "renderer/view_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <variant>

#include "camera/projection.h"

namespace alidade {
namespace {

/// Where a ray stands in the camera's own axes, seen at distance 1 before the camera: its direction there, or
/// for parallel rays its origin. Empty behind a right angle.
std::optional<glm::dvec2> place_at_one(const Ray& ray, const CameraPose& pose, bool is_parallel) {
  const glm::dvec3 way = is_parallel ? ray.origin - pose.position : ray.direction;
  const glm::dvec2 beside(glm::dot(way, pose.right), glm::dot(way, pose.down));
  if (is_parallel) return beside;
  constexpr double k_least = 0.02;  // about 89 degrees
  const double ahead = glm::dot(way, pose.forward);
  if (ahead < k_least) return std::nullopt;
  return beside / ahead;
}

}  // namespace

HalfSpaces view_planes(const Camera& camera) {
  constexpr int k_sides = 16, k_places_per_side = 64;
  const bool is_parallel = std::holds_alternative<OrthographicLens>(camera.lens);
  const bool is_straight = is_parallel || std::holds_alternative<PinholeLens>(camera.lens);
  const CameraPose& pose = camera.pose;
  const Projection projection(camera);
  std::array<double, k_sides> reach;
  reach.fill(-std::numeric_limits<double>::infinity());
  std::array<glm::dvec2, k_sides> sides;
  for (int side = 0; side < k_sides; ++side) {
    const double angle = 2.0 * std::numbers::pi * side / k_sides;
    sides[static_cast<std::size_t>(side)] = {std::cos(angle), std::sin(angle)};
  }
  for (int i = 0; i <= k_places_per_side; ++i) {
    const double share = static_cast<double>(i) / k_places_per_side;
    const double x = share * camera.width, y = share * camera.height;
    for (const glm::dvec2 film : {glm::dvec2(x, 0.0), glm::dvec2(x, camera.height), glm::dvec2(0.0, y),
                                  glm::dvec2(camera.width, y)}) {
      const std::optional<Ray> ray = projection.ray(film);
      const std::optional<glm::dvec2> place = ray ? place_at_one(*ray, pose, is_parallel) : std::nullopt;
      if (!place) return {};
      for (std::size_t side = 0; side < k_sides; ++side)
        reach[side] = std::max(reach[side], glm::dot(*place, sides[side]));
    }
  }
  // Between two places looked at, a bent border may reach further; and numbers are rounded.
  const double slack = is_straight ? 1e-9 : 0.02;
  HalfSpaces planes;
  for (std::size_t side = 0; side < k_sides; ++side) {
    const glm::dvec3 outwards = sides[side].x * pose.right + sides[side].y * pose.down;
    const double furthest = reach[side] + slack * (1.0 + std::abs(reach[side]));
    planes.planes.push_back(is_parallel ? make_plane(pose.position + furthest * outwards, -outwards)
                                        : make_plane(pose.position, furthest * pose.forward - outwards));
  }
  planes.planes.push_back(make_plane(pose.position, pose.forward));
  return planes;
}

}  // namespace alidade
