// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "visibility/observers.h"
#include "visibility/sight_line.h"

namespace alidade {

/// Heights above the ground, limits inclusive.
struct HeightRange {
  double low = 0.0, high = 0.0;
};

/// An observer ready for many lines of sight.
class MapObserver {
 public:
  MapObserver(const Occluders& occluders, const Observer& observer);

  const SightEnd& eye() const { return eye_; }

  /// Whether it looks at a place at all.
  bool looks_at(const glm::dvec3& place) const { return view_.reaches(place - eye_.position); }

  /// The heights in `asked` above a place that it looks at: those between the lower and the upper limit of
  /// its field of view there, not farther away than its distance. Its lower end is that of `asked` if the
  /// observer looks at that, by looks_at(). Empty: it looks at none. The same on every machine.
  std::optional<HeightRange> heights_in_view(const glm::dvec3& foot, const HeightRange& asked) const;

 private:
  SightEnd eye_;
  FieldOfView view_, azimuths_;
  double max_distance_;
  double lower_slope_, upper_slope_;  ///< rise per length of the ground at the limits of the view
};

inline std::vector<MapObserver> map_observers(const Occluders& occluders,
                                              std::span<const Observer> observers) {
  std::vector<MapObserver> all;
  for (const Observer& observer : observers) all.emplace_back(occluders, observer);
  return all;
}

}  // namespace alidade
