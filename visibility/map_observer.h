// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "visibility/observers.h"
#include "visibility/sight_line.h"

namespace alidade {

/// An observer ready for many lines of sight.
struct MapObserver {
  SightEnd eye;
  FieldOfView view;
  double max_distance_sq;

  MapObserver(const Occluders& occluders, const Observer& observer)
      : eye(end_near_surface(occluders, observer.position)),
        view(observer),
        max_distance_sq(observer.max_distance * observer.max_distance) {}

  /// Whether it looks at a place at all.
  bool looks_at(const glm::dvec3& place) const {
    const glm::dvec3 offset = place - eye.position;
    return glm::dot(offset, offset) <= max_distance_sq && (view.is_everything() || view.contains(offset));
  }
};

inline std::vector<MapObserver> map_observers(const Occluders& occluders,
                                              std::span<const Observer> observers) {
  std::vector<MapObserver> all;
  for (const Observer& observer : observers) all.emplace_back(occluders, observer);
  return all;
}

}  // namespace alidade
