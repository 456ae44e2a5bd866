// SPDX-License-Identifier: MIT
#include "renderer/cloud_in_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <queue>
#include <variant>

#include "camera/projection.h"
#include "cloud/cloud_inputs.h"
#include "image/color_points.h"

namespace alidade::renderer {
namespace {

/// Where a ray is in the camera's own axes, seen at distance 1 before the camera: its direction there, or
/// for parallel rays its origin. Empty behind a right angle.
std::optional<glm::dvec2> point_at_one(const Ray& ray, const camera::CameraPose& pose, bool is_parallel) {
  const glm::dvec3 way = is_parallel ? ray.origin - pose.position : ray.direction;
  const glm::dvec2 beside(glm::dot(way, pose.right), glm::dot(way, pose.down));
  if (is_parallel) return beside;
  constexpr double k_least = 0.02;  // about 89 degrees
  const double ahead = glm::dot(way, pose.forward);
  if (ahead < k_least) return std::nullopt;
  return beside / ahead;
}

/// Calls visit(ray) with rays along the border of the image, empty where there is none, until it returns
/// false. False if it did.
template <class Visit>
bool along_border(const camera::Camera& camera, int rays_per_side, const Visit& visit) {
  const camera::Projection projection(camera);
  for (int i = 0; i <= rays_per_side; ++i) {
    const double share = static_cast<double>(i) / rays_per_side;
    const double x = share * camera.width, y = share * camera.height;
    for (const glm::dvec2 film : {glm::dvec2(x, 0.0), glm::dvec2(x, camera.height), glm::dvec2(0.0, y),
                                  glm::dvec2(camera.width, y)}) {
      if (!visit(projection.ray(film))) return false;
    }
  }
  return true;
}

/// What a camera sees, as a cone around its axis.
class ViewCone {
 public:
  explicit ViewCone(const camera::Camera& camera) : pose_(camera.pose), half_angle_(half_angle(camera)) {}

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
  static double half_angle(const camera::Camera& camera) {
    constexpr int k_rays_per_side = 32;
    double widest = 0.0;
    const auto widen = [&](const std::optional<Ray>& ray) {
      const double cosine = ray ? glm::dot(ray->direction, camera.pose.forward) : 0.0;
      widest = std::max(widest, std::acos(std::clamp(cosine, -1.0, 1.0)));
      return ray.has_value();
    };
    return along_border(camera, k_rays_per_side, widen) ? widest : std::numbers::pi;
  }

  camera::CameraPose pose_;
  double half_angle_;
};

struct CandidateNode {
  double spacing;  ///< of its points in the image, in any unit
  std::size_t file;
  std::uint32_t node;

  /// Coarse nodes come first; among equals the order is that of the files, so that it is always the same.
  bool operator<(const CandidateNode& other) const {
    if (spacing != other.spacing) return spacing < other.spacing;
    return std::pair(file, node) > std::pair(other.file, other.node);
  }
};

}  // namespace

HalfSpaces view_planes(const camera::Camera& camera) {
  constexpr int k_sides = 16, k_rays_per_side = 64;
  const bool is_parallel = std::holds_alternative<camera::OrthographicLens>(camera.lens);
  const bool is_straight = is_parallel || std::holds_alternative<camera::PinholeLens>(camera.lens);
  const camera::CameraPose& pose = camera.pose;
  std::array<double, k_sides> reach;
  reach.fill(-std::numeric_limits<double>::infinity());
  std::array<glm::dvec2, k_sides> sides;
  for (int side = 0; side < k_sides; ++side) {
    const double angle = 2.0 * std::numbers::pi * side / k_sides;
    sides[static_cast<std::size_t>(side)] = {std::cos(angle), std::sin(angle)};
  }
  const auto widen = [&](const std::optional<Ray>& ray) {
    const std::optional<glm::dvec2> point = ray ? point_at_one(*ray, pose, is_parallel) : std::nullopt;
    for (std::size_t side = 0; point && side < k_sides; ++side)
      reach[side] = std::max(reach[side], glm::dot(*point, sides[side]));
    return point.has_value();
  };
  if (!along_border(camera, k_rays_per_side, widen)) return {};
  // Between two rays a bent border may reach further; and numbers are rounded.
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

std::vector<ChosenNodes> nodes_in_view(std::span<const std::unique_ptr<CopcFile>> files,
                                       const camera::Camera* camera, std::uint64_t most_points) {
  const bool is_perspective =
      camera != nullptr && !std::holds_alternative<camera::OrthographicLens>(camera->lens);
  const std::optional<ViewCone> cone = is_perspective ? std::optional<ViewCone>(*camera) : std::nullopt;
  std::priority_queue<CandidateNode> candidates;
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
    const CandidateNode next = candidates.top();
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

std::vector<std::unique_ptr<CopcFile>> open_copc_cloud(const CloudInputs& inputs) {
  constexpr std::size_t k_most_files = 256;  // all of which stay open
  std::vector<std::unique_ptr<CopcFile>> files;
  if (inputs.size() > k_most_files) return files;
  for (const CloudInput& input : inputs.inputs) {
    InputFile file = input.file();
    if (!input.is(k_copc_format)) return {};
    files.push_back(std::make_unique<CopcFile>(std::move(file), false, &input));
  }
  return files;
}

LoadedCloud load_coarse_cloud(const CloudSettings& wanted, const CloudInputs& inputs,
                              const std::vector<std::unique_ptr<CopcFile>>& files,
                              const camera::Camera* camera, std::uint64_t most_points,
                              const Progress& progress) {
  CloudSettings settings = wanted;
  double widest = 0.0;
  for (const auto& file : files) widest = std::max(widest, file->info().spacing);
  settings.radius.reset();
  settings.adapted_radius = AdaptedRadius{.max = widest};
  settings.shape = PointShape::sphere;  // measuring sheets would take longer than the image
  const AttributeSet attributes =
      image::check_color_of_files(settings.color, inputs, Damage::reject, inputs.first_name().string());
  const std::vector<ChosenNodes> nodes = nodes_in_view(files, camera, most_points);
  LoadedCloud loaded =
      index_cloud(read_copc_nodes(nodes, {.attributes = image::attributes_for(settings.color),
                                          .color_depth = settings.color_depth,
                                          .progress = progress}),
                  attributes, settings, inputs.title());
  choose_radius(settings, loaded);
  return loaded;
}

}  // namespace alidade::renderer
