// SPDX-License-Identifier: MIT
#include "visibility/observer_remarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "octree/point_surface.h"
#include "octree/query.h"
#include "visibility/crossing.h"

namespace alidade {
namespace {

/// So far outside, metres, an observer of even the smallest cloud is not strange.
constexpr double k_never_far = 100.0;

/// Distance to a box, 0 inside.
double distance_to(const Bounds& box, const glm::dvec3& place) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.min[axis] - place[axis], place[axis] - box.max[axis], 0.0});
    sum += outside * outside;
  }
  return std::sqrt(sum);
}

/// Whether there are points near a place in plan, and all of them above it.
bool is_below_all(const Octree& octree, const glm::dvec3& place) {
  constexpr double k_far = std::numeric_limits<double>::infinity(), k_largest_reach = 16.0;
  for (double reach = 1.0; reach <= k_largest_reach; reach *= 2.0) {
    Bounds column{.min = {place.x - reach, place.y - reach, -k_far},
                  .max = {place.x + reach, place.y + reach, place.z}};
    if (count(octree, column, {.k = 1}) > 0) return false;
    column.max.z = k_far;
    if (count(octree, column, {.k = 1}) > 0) return true;
  }
  return false;
}

/// Radius of a point's sphere; 0 if it has none.
double sphere_radius_of(const Occluders& occluders, const PointHit& point) {
  const OccluderOptions& options = occluders.options();
  if (options.counts && !options.counts(point.point_id)) return 0.0;
  if (occluders.has_surfaces()) {
    const bool is_disc = surface_of(occluders.octree().view(), point.point_id).exists;
    if (is_disc || options.shape == OccluderShape::disc) return 0.0;
  }
  if (options.radius) return *options.radius;
  // A point's spacing is the distance to its 8th neighbour.
  constexpr std::size_t k_with_neighbours = 9;
  const auto neighbours = find(occluders.octree(), point.position, {.k = k_with_neighbours});
  return sphere_of(occluders, candidate_radius(occluders, neighbours.back().distance));
}

std::string remark_on(const Occluders& occluders, const Observer& observer) {
  const Bounds& box = occluders.octree().bounds();
  const double outside = distance_to(box, observer.position);
  if (outside > observer.max_distance) {
    return fmt::format("{} sees nothing: the cloud begins {:.6g} away, and it sees {:.6g} far", observer.name,
                       outside, observer.max_distance);
  }
  if (outside > std::max(glm::length(box.size()), k_never_far))
    return fmt::format("{} is {:.6g} outside of the cloud; is it in the cloud's coordinates?", observer.name,
                       outside);
  if (!observer.stands_on_ground && is_below_all(occluders.octree(), observer.position))
    return fmt::format("{} is below all points near it, in the ground", observer.name);
  const auto nearest = find(occluders.octree(), observer.position, {.k = 1});
  if (!nearest.empty() && nearest[0].distance < sphere_radius_of(occluders, nearest[0])) {
    return fmt::format("{} is inside point {}, {:.3g} from its middle; that point does not block its view",
                       observer.name, nearest[0].point_id, nearest[0].distance);
  }
  return "";
}

}  // namespace

std::vector<std::string> observer_remarks(const Occluders& occluders, std::span<const Observer> observers) {
  std::vector<std::string> remarks;
  if (occluders.octree().size() == 0) return remarks;
  for (const Observer& observer : observers) {
    std::string remark = remark_on(occluders, observer);
    if (!remark.empty()) remarks.push_back(std::move(remark));
  }
  return remarks;
}

}  // namespace alidade
