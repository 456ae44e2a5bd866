// SPDX-License-Identifier: MIT
#include "renderer/nodes_in_view.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <queue>
#include <variant>

#include "camera/projection.h"

namespace alidade {
namespace {

/// What a camera sees, as a cone around its axis.
class ViewCone {
 public:
  explicit ViewCone(const Camera& camera) : pose_(camera.pose), half_angle_(half_angle(camera)) {}

  bool meets(const Bounds& box) const {
    const glm::dvec3 way = 0.5 * (box.min + box.max) - pose_.position;
    const double radius = 0.5 * glm::distance(box.min, box.max);
    const double distance = glm::length(way);
    if (distance <= radius) return true;
    const double off_axis = std::acos(std::clamp(glm::dot(way, pose_.forward) / distance, -1.0, 1.0));
    return off_axis <= half_angle_ + std::asin(radius / distance);
  }

 private:
  /// The widest angle along the border of the image; everything if the lens does not see all of it.
  static double half_angle(const Camera& camera) {
    constexpr int k_places_per_side = 32;
    const Projection projection(camera);
    double widest = 0.0;
    for (int i = 0; i <= k_places_per_side; ++i) {
      const double share = static_cast<double>(i) / k_places_per_side;
      const double x = share * camera.width, y = share * camera.height;
      for (const glm::dvec2 place : {glm::dvec2(x, 0.0), glm::dvec2(x, camera.height), glm::dvec2(0.0, y),
                                     glm::dvec2(camera.width, y)}) {
        const std::optional<Ray> ray = projection.ray(place);
        if (!ray) return std::numbers::pi;
        widest =
            std::max(widest, std::acos(std::clamp(glm::dot(ray->direction, camera.pose.forward), -1.0, 1.0)));
      }
    }
    return widest;
  }

  CameraPose pose_;
  double half_angle_;
};

double distance_to(const Bounds& box, const glm::dvec3& place) {
  return glm::distance(place, glm::clamp(place, box.min, box.max));
}

struct Candidate {
  double spacing;  ///< of its points in the picture, in any unit
  std::size_t file;
  std::uint32_t node;

  /// Coarse nodes come first; among equals the order is that of the files, so that it is always the same.
  bool operator<(const Candidate& other) const {
    if (spacing != other.spacing) return spacing < other.spacing;
    return std::pair(file, node) > std::pair(other.file, other.node);
  }
};

}  // namespace

std::vector<ChosenNodes> nodes_in_view(std::span<const std::unique_ptr<CopcFile>> files, const Camera* camera,
                                       std::uint64_t most_points) {
  const bool is_perspective = camera != nullptr && !std::holds_alternative<OrthographicLens>(camera->lens);
  const std::optional<ViewCone> cone = is_perspective ? std::optional<ViewCone>(*camera) : std::nullopt;
  std::priority_queue<Candidate> candidates;
  const auto add = [&](std::size_t file, std::uint32_t number) {
    const CopcFile& copc = *files[file];
    const CopcNode& node = copc.hierarchy().nodes[number];
    const Bounds cube = copc.bounds(node);
    if (cone && !cone->meets(cube)) return;
    double spacing = std::ldexp(copc.info().spacing, -node.key.level);
    // Nothing nearer than the points are apart is worth more.
    if (cone) spacing /= std::max(distance_to(cube, camera->pose.position), spacing);
    candidates.push({spacing, file, number});
  };
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!files[i]->hierarchy().nodes.empty()) add(i, 0);
  }

  std::vector<std::vector<std::uint32_t>> chosen(files.size());
  std::uint64_t points = 0;
  while (!candidates.empty()) {
    const Candidate next = candidates.top();
    const CopcNode& node = files[next.file]->hierarchy().nodes[next.node];
    candidates.pop();
    if (next.node != 0 && points + node.chunk.point_count > most_points) continue;
    points += node.chunk.point_count;
    chosen[next.file].push_back(next.node);
    for (const std::uint32_t child : files[next.file]->hierarchy().children_of(node)) add(next.file, child);
  }
  std::vector<ChosenNodes> parts;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::ranges::sort(chosen[i]);
    if (!chosen[i].empty()) parts.push_back({files[i].get(), std::move(chosen[i])});
  }
  return parts;
}

}  // namespace alidade
