// SPDX-License-Identifier: MIT
#include "visibility/raster/map_observer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/exact_math.h"

namespace alidade {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Rise per length of the ground; straight up and down it is infinite.
double slope_of(double elevation) {
  if (elevation >= 90.0) return k_infinity;
  if (elevation <= -90.0) return -k_infinity;
  const SineCosine angle = sine_cosine_of_degrees(elevation);
  return angle.sine / angle.cosine;
}

Observer at_any_elevation(Observer observer) {
  observer.elevation_min = -90.0;
  observer.elevation_max = 90.0;
  return observer;
}

}  // namespace

MapObserver::MapObserver(const Occluders& occluders, const Observer& observer)
    : eye_(end_near_surface(occluders, observer.position)),
      view_(observer),
      azimuths_(at_any_elevation(observer)),
      max_distance_(observer.max_distance),
      lower_slope_(slope_of(observer.elevation_min)),
      upper_slope_(slope_of(observer.elevation_max)) {}

std::optional<HeightRange> MapObserver::heights_in_view(const glm::dvec3& foot,
                                                        const HeightRange& asked) const {
  const glm::dvec3 offset = foot - eye_.position;
  const double run_sq = offset.x * offset.x + offset.y * offset.y, run = std::sqrt(run_sq);
  const double reach_sq = max_distance_ * max_distance_ - run_sq;
  if (!azimuths_.contains({offset.x, offset.y, 0.0}) || reach_sq < 0.0) return std::nullopt;
  const double reach = std::sqrt(reach_sq);
  // No way along the ground times an infinite slope would be no number.
  const double lowest = std::isinf(lower_slope_) ? lower_slope_ : run * lower_slope_,
               highest = std::isinf(upper_slope_) ? upper_slope_ : run * upper_slope_;
  HeightRange range{std::max(asked.low, std::max(lowest, -reach) - offset.z),
                    std::min(asked.high, std::min(highest, reach) - offset.z)};
  // What a rounding decides is decided as for the lowest place alone.
  if (looks_at(foot + glm::dvec3(0.0, 0.0, asked.low))) {
    range.low = asked.low;
    range.high = std::max(range.high, asked.low);
  }
  if (!(range.low <= range.high)) return std::nullopt;
  return range;
}

}  // namespace alidade
