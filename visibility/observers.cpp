// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/text_scanner.h"

namespace alidade {
namespace {

constexpr double k_turn = 360.0;
/// Up to here a place is good to a tenth of a millimetre.
constexpr double k_largest_coordinate = 1e12;

/// Unit vector (east, north) of an azimuth.
glm::dvec2 direction_of(double azimuth) {
  const SineCosine at = sine_cosine_of_degrees(azimuth);
  return {at.sine, at.cosine};
}

/// Cosine and sine.
glm::dvec2 slope_of(double elevation) {
  const SineCosine at = sine_cosine_of_degrees(elevation);
  return {at.cosine, at.sine};
}

/// Above 0 where b lies counterclockwise of a.
double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Degrees from the first limit clockwise to the second; negative if they do not make a range.
double azimuth_width(double azimuth_min, double azimuth_max) {
  const double width = azimuth_max - azimuth_min;
  return width < 0.0 ? width + k_turn : width;
}

[[noreturn]] void refuse(const std::string& source, std::string problem, std::string expected,
                         std::string found) {
  throw Error({.file = source,
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

void require_range(const std::string& source, const char* what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  refuse(source, fmt::format("{} is out of range", what), fmt::format("a number from {} to {}", least, most),
         fmt::format("{}", value));
}

void check_view(const std::string& source, const Observer& observer) {
  constexpr double k_inf = std::numeric_limits<double>::infinity();
  constexpr double k_most = std::numeric_limits<double>::max();
  require_range(source, "height", observer.height, 0.0, k_most);
  require_range(source, "max_distance", observer.max_distance, 0.0, k_inf);
  require_range(source, "azimuth_min", observer.azimuth_min, -k_turn, 2.0 * k_turn);
  require_range(source, "azimuth_max", observer.azimuth_max, -k_turn, 2.0 * k_turn);
  require_range(source, "elevation_min", observer.elevation_min, -90.0, 90.0);
  require_range(source, "elevation_max", observer.elevation_max, -90.0, 90.0);
  if (!(azimuth_width(observer.azimuth_min, observer.azimuth_max) > 0.0)) {
    refuse(source, "the azimuths leave no field of view", "two that differ, clockwise from north",
           fmt::format("{} to {}", observer.azimuth_min, observer.azimuth_max));
  }
  if (observer.elevation_min > observer.elevation_max) {
    refuse(source, "the elevations stand upside down", "the lower one first",
           fmt::format("{} to {}", observer.elevation_min, observer.elevation_max));
  }
}

}  // namespace

FieldOfView::FieldOfView(const Observer& observer) {
  const double width = azimuth_width(observer.azimuth_min, observer.azimuth_max);
  all_azimuths_ = width >= k_turn;
  all_elevations_ = observer.elevation_min <= -90.0 && observer.elevation_max >= 90.0;
  max_distance_sq_ = observer.max_distance * observer.max_distance;
  is_wide_ = width > 0.5 * k_turn;
  from_ = direction_of(observer.azimuth_min);
  to_ = direction_of(observer.azimuth_max);
  low_ = slope_of(observer.elevation_min);
  high_ = slope_of(observer.elevation_max);
}

bool FieldOfView::contains(const glm::dvec3& offset) const {
  const glm::dvec2 across(offset.x, offset.y);
  if (!all_azimuths_) {
    const double from = cross(from_, across), to = cross(to_, across);
    if (is_wide_ ? to < 0.0 && from > 0.0 : from > 0.0 || to < 0.0) return false;
  }
  if (all_elevations_) return true;
  const double run = std::sqrt(across.x * across.x + across.y * across.y);
  return offset.z * low_.x >= run * low_.y && offset.z * high_.x <= run * high_.y;
}

bool FieldOfView::reaches(const glm::dvec3& offset) const {
  return glm::dot(offset, offset) <= max_distance_sq_ && contains(offset);
}

GivenObserver parse_observer(const std::string& text) {
  GivenObserver given{.source = "--observer " + text};
  std::vector<std::string_view> cells;
  split_cells(text, ',', cells);
  const auto fail = [&] {
    throw Error({.file = given.source,
                 .problem = "is no place",
                 .expected = "X,Y,Z, or X,Y for a place on the ground"});
  };
  if (cells.size() != 2 && cells.size() != 3) fail();
  double numbers[3] = {};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::optional<double> number = parse_number(cells[i]);
    if (!number || !std::isfinite(*number)) fail();
    numbers[i] = *number;
  }
  given.place = {numbers[0], numbers[1]};
  if (cells.size() == 3) given.z = numbers[2];
  return given;
}

std::vector<Observer> place_observers(std::span<const GivenObserver> given, const ObserverDefaults& defaults,
                                      const GroundHeight& ground) {
  std::vector<Observer> observers;
  observers.reserve(given.size());
  for (const GivenObserver& one : given) {
    Observer observer;
    observer.name = one.name.empty() ? fmt::format("observer {}", observers.size() + 1) : one.name;
    const double usual_height = defaults.height.value_or(one.z ? 0.0 : defaults.height_on_ground);
    observer.height = one.height.value_or(usual_height);
    observer.azimuth_min = one.azimuth_min.value_or(defaults.azimuth_min);
    observer.azimuth_max = one.azimuth_max.value_or(defaults.azimuth_max);
    observer.elevation_min = one.elevation_min.value_or(defaults.elevation_min);
    observer.elevation_max = one.elevation_max.value_or(defaults.elevation_max);
    observer.max_distance = one.max_distance.value_or(defaults.max_distance);
    check_view(one.source, observer);
    const std::optional<double> foot = one.z ? one.z : ground(one.place);
    if (!foot) {
      refuse(one.source, "has no points of the cloud below to stand on", "a place inside the cloud, or a z",
             fmt::format("{}, {}", one.place.x, one.place.y));
    }
    observer.stands_on_ground = !one.z;
    observer.position = glm::dvec3(one.place, *foot + observer.height);
    const glm::dvec3& eye = observer.position;
    for (const double coordinate : {eye.x, eye.y, eye.z}) {
      if (std::fabs(coordinate) <= k_largest_coordinate) continue;
      refuse(one.source, "is at no place that a cloud can have",
             fmt::format("coordinates from {} to {}", -k_largest_coordinate, k_largest_coordinate),
             fmt::format("{}, {}, {}", eye.x, eye.y, eye.z));
    }
    observers.push_back(observer);
  }
  return observers;
}

}  // namespace alidade
