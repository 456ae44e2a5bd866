// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <string_view>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/parallel.h"
#include "base/words.h"
#include "octree/query.h"
#include "visibility/crossing.h"

namespace alidade::visibility {
namespace {

constexpr double k_full_turn = 360.0;

/// Up to this, doubles resolve a tenth of a millimetre.
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
  return width < 0.0 ? width + k_full_turn : width;
}

[[noreturn]] void reject(const std::string& source, std::string problem, std::string expected,
                         std::string found) {
  throw Error(source, {}, std::move(problem), std::move(expected), std::move(found));
}

void require_range(const std::string& source, const char* what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  reject(source, fmt::format("{} out of range", what), fmt::format("a number from {} to {}", least, most),
         fmt::format("{}", value));
}

void check_view(const std::string& source, const Observer& observer) {
  constexpr double k_inf = std::numeric_limits<double>::infinity();
  constexpr double k_most = std::numeric_limits<double>::max();
  require_range(source, "height", observer.height, 0.0, k_most);
  require_range(source, "max_distance", observer.max_distance, 0.0, k_inf);
  require_range(source, "azimuth_min", observer.azimuth_min, -k_full_turn, 2.0 * k_full_turn);
  require_range(source, "azimuth_max", observer.azimuth_max, -k_full_turn, 2.0 * k_full_turn);
  require_range(source, "elevation_min", observer.elevation_min, -90.0, 90.0);
  require_range(source, "elevation_max", observer.elevation_max, -90.0, 90.0);
  if (!(azimuth_width(observer.azimuth_min, observer.azimuth_max) > 0.0)) {
    reject(source, "empty field of view", "two different azimuths, clockwise from north",
           fmt::format("{} to {}", observer.azimuth_min, observer.azimuth_max));
  }
  if (observer.elevation_min > observer.elevation_max) {
    reject(source, "elevations out of order", "the lower elevation first",
           fmt::format("{} to {}", observer.elevation_min, observer.elevation_max));
  }
}

/// Observers are not remarked on up to this distance outside the cloud, metres, however small it is.
constexpr double k_never_far = 100.0;

/// Whether there are points near a position in plan, all of them above it.
bool is_below_all(const Octree& octree, const glm::dvec3& position) {
  constexpr double k_far = std::numeric_limits<double>::infinity(), k_largest_reach = 16.0;
  for (double reach = 1.0; reach <= k_largest_reach; reach *= 2.0) {
    Bounds column{.min = {position.x - reach, position.y - reach, -k_far},
                  .max = {position.x + reach, position.y + reach, position.z}};
    if (count(octree, column, {.k = 1}) > 0) return false;
    column.max.z = k_far;
    if (count(octree, column, {.k = 1}) > 0) return true;
  }
  return false;
}

/// As candidate_radius().
double radius_of(const Occluders& occluders, const PointHit& point) {
  if (occluders.options().radius) return *occluders.options().radius;
  // A point's spacing is the distance to its 8th neighbour.
  constexpr std::size_t k_with_neighbours = 9;
  const auto neighbours = find(occluders.octree(), point.position, {.k = k_with_neighbours});
  return candidate_radius(occluders, neighbours.back().distance);
}

/// Says that an observer is in the sphere of a point, or so near its disc that this hides nearly half of the
/// view; empty if it is neither.
std::string remark_on(const Occluders& occluders, const Observer& observer, const PointHit& point) {
  const OccluderOptions& options = occluders.options();
  if (options.counts && !options.counts(point.point_id)) return "";
  const PointSurface surface = occluders.has_surfaces() ? occluders.surface(point.point_id) : PointSurface();
  if (!surface.exists) {
    const bool is_sphere = !occluders.has_surfaces() || options.shape != OccluderShape::disc;
    if (!is_sphere || point.distance > occluders.largest_radius()) return "";
    const double radius = radius_of(occluders, point);
    if (point.distance >= (options.radius ? radius : sphere_of(occluders, radius))) return "";
    return fmt::format("{} is inside point {}, {:.3g} from its centre; that point does not block its view",
                       observer.name, point.point_id, point.distance);
  }
  constexpr double k_near = 0.1;  // of the disc around the foot of the perpendicular: 45 % of all directions
  // Ground is expected to hide what is below it.
  constexpr double k_steepest_ground = 0.7;
  if (std::fabs(surface.normal.z) > k_steepest_ground && observer.position.z > point.position.z) return "";
  const auto is_near = [&](double height, double along, double radius) {
    return height <= k_near * (radius - along);
  };
  PointDisc disc = point_disc(point.position, surface, 0.0);
  const double height = std::fabs(glm::dot(observer.position - disc.center, disc.normal));
  const double along = std::sqrt(std::max(0.0, point.distance * point.distance - height * height));
  if (!is_near(height, along, occluders.largest_radius())) return "";
  disc.radius = disc_of(occluders, radius_of(occluders, point));
  if (!is_near(height, along, disc.radius)) return "";
  return fmt::format(
      "{} is {:.3g} from the disc of point {}, whose radius is {:.3g}: it hides nearly half of the view; "
      "move the observer, or set --radius-max",
      observer.name, height, point.point_id, disc.radius);
}

/// Whether a position is below a terrain by more than an end of a line may be.
bool is_below(const geo::TerrainSurface& terrain, const glm::dvec3& position) {
  return terrain.occluded({position, {0.0, 0.0, 1.0}, k_mesh_contact});
}

/// Metres along a vertical line to the first thing on it.
std::optional<double> first_along(const Occluders& occluders, const SightLine& line) {
  const OccluderOptions& options = occluders.options();
  double first = std::numeric_limits<double>::infinity();
  const auto take = [&first](const auto& hit) {
    if (hit) first = std::min(first, std::max(hit->t, 0.0));
  };
  with_query(occluders, [&](const auto& cloud, auto query) {
    query.filter.of_point = counted_alone(occluders);
    query.filter.of_position = [&](const Candidate& candidate) {
      return position_crossing(occluders, line, candidate).has_value();
    };
    take(closest(cloud, ray_of(occluders, line), query));
  });
  // Points beside the start are not above it.
  const double beside = occluders.typical_radius();
  if (options.shape != OccluderShape::disc && beside < line.length) {
    RayQuery lone{.radius = beside, .measure = Measure::t};
    lone.filter.of_point = counted_alone(occluders);
    lone.filter.of_position = [&](const Candidate& point) {
      return !occluders.surface(point.point_id).exists;
    };
    take(closest(occluders.octree(), Ray{line.from.position, line.direction, beside, line.length}, lone));
  }
  const Ray ray{line.from.position, line.direction, k_mesh_contact, line.length};
  if (options.mesh != nullptr) take(options.mesh->closest(ray));
  if (options.terrain != nullptr) take(options.terrain->closest(ray));
  return std::isinf(first) ? std::nullopt : std::optional(first);
}

/// z of the highest thing at a position.
std::optional<double> top_at(const Occluders& occluders, const glm::dvec3& position) {
  Bounds all = occluders.octree().bounds();
  const OccluderOptions& options = occluders.options();
  if (options.mesh != nullptr) all.grow(options.mesh->bounds());
  if (options.terrain != nullptr) all.grow(options.terrain->bounds());
  const double start = all.max.z + 1.0 + occluders.largest_radius();
  const auto depth =
      first_along(occluders, sight_ray(chord_end({position.x, position.y, start}), {0, 0, -1}));
  return depth ? std::optional(start - *depth) : std::nullopt;
}

/// The option for the same observer with its foot at this z.
std::string instead_of(const Observer& observer, double foot) {
  const double height = observer.height > 0.0 ? observer.height : k_usual_observer_height;
  return fmt::format("--observer={:.3f},{:.3f},{:.3f} --observer-height {:g} (in a file: z, height)",
                     observer.position.x, observer.position.y, foot, height);
}

/// Says that an observer is below something, or that its foot is not on what is
/// there; empty if it is neither.
std::string remark_on_clearance(const Occluders& occluders, const Observer& observer) {
  constexpr double k_off = 1.0;
  const Clearance clearance = clearance_of(occluders, observer.position);
  std::string remark;
  if (clearance.above) {
    remark = fmt::format("{} has something {:.2f} above its eye, which hides the sky", observer.name,
                         *clearance.above);
    if (const auto top = top_at(occluders, observer.position))
      remark += fmt::format("; to look from its top, type {}", instead_of(observer, *top));
  }
  const bool has_foot = observer.stands_on_ground || observer.height > 0.0;
  const double off = clearance.below.value_or(0.0) - observer.height;
  if (!clearance.below || !has_foot || std::fabs(off) <= k_off) return remark;
  return fmt::format("{}{}the foot of {} is {:.2f} {} what is there; to stand on that, type {}", remark,
                     remark.empty() ? "" : "; ", observer.name, std::fabs(off), off > 0.0 ? "above" : "below",
                     instead_of(observer, observer.position.z - *clearance.below));
}

std::string remark_on(const Occluders& occluders, const Observer& observer) {
  const auto& terrain = occluders.options().terrain;
  const bool has_points = occluders.octree().size() > 0;
  const char* const all = has_points ? "cloud" : "raster";
  Bounds box = occluders.octree().bounds();
  if (terrain != nullptr) box.grow(terrain->bounds());
  const double outside = distance_to(box, observer.position);
  if (outside > observer.max_distance) {
    return fmt::format("{} sees nothing: the {} is {:.6g} away, beyond the maximum distance {:.6g}",
                       observer.name, all, outside, observer.max_distance);
  }
  if (outside > std::max(glm::length(box.size()), k_never_far))
    return fmt::format("{} is {:.6g} outside the {}; check its reference system", observer.name, outside,
                       all);
  if (terrain != nullptr && is_below(*terrain, observer.position))
    return fmt::format("{} is below the surface of the raster", observer.name);
  if (!has_points) return observer.is_placed ? remark_on_clearance(occluders, observer) : "";
  if (!observer.stands_on_ground && is_below_all(occluders.octree(), observer.position))
    return fmt::format("{} is below all points near it", observer.name);
  constexpr std::size_t k_near_points = 16;
  for (const PointHit& point : find(occluders.octree(), observer.position, {.k = k_near_points})) {
    std::string remark = remark_on(occluders, observer, point);
    if (!remark.empty()) return remark;
  }
  return observer.is_placed ? remark_on_clearance(occluders, observer) : "";
}

}  // namespace

FieldOfView::FieldOfView(const Observer& observer) {
  const double width = azimuth_width(observer.azimuth_min, observer.azimuth_max);
  all_azimuths_ = width >= k_full_turn;
  all_elevations_ = observer.elevation_min <= -90.0 && observer.elevation_max >= 90.0;
  max_distance_sq_ = observer.max_distance * observer.max_distance;
  is_wide_ = width > 0.5 * k_full_turn;
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
    throw Error(given.source, {}, "invalid position", "X,Y,Z, or X,Y for a position on the ground");
  };
  if (cells.size() != 2 && cells.size() != 3) fail();
  double numbers[3] = {};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::optional<double> number = parse_number(cells[i]);
    if (!number || !std::isfinite(*number)) fail();
    numbers[i] = *number;
  }
  given.position = {numbers[0], numbers[1]};
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
    const std::optional<double> foot = one.z ? one.z : ground(one.position);
    if (!foot) {
      reject(one.source, "no ground below the observer", "a position inside the cloud or raster, or a z",
             fmt::format("{}, {}", one.position.x, one.position.y));
    }
    observer.stands_on_ground = !one.z;
    observer.is_placed = true;
    observer.position = glm::dvec3(one.position, *foot + observer.height);
    const glm::dvec3& eye = observer.position;
    for (const double coordinate : {eye.x, eye.y, eye.z}) {
      if (std::fabs(coordinate) <= k_largest_coordinate) continue;
      reject(one.source, "position out of range",
             fmt::format("coordinates from {} to {}", -k_largest_coordinate, k_largest_coordinate),
             fmt::format("{}, {}, {}", eye.x, eye.y, eye.z));
    }
    observers.push_back(observer);
  }
  return observers;
}

std::vector<GivenObserver> observer_grid(const Bounds& extent, double width, const GroundHeight& ground,
                                         const Progress& progress) {
  check_that(width > 0.0 && std::isfinite(width), "invalid observer grid", "a positive width");
  // The extent of a line of points has no width, and must have a cell all the same.
  const double columns = std::fmax(1.0, std::ceil((extent.max.x - extent.min.x) / width));
  const double rows = std::fmax(1.0, std::ceil((extent.max.y - extent.min.y) / width));
  check_that(columns * rows <= k_most_grid_observers,
             fmt::format("too many positions in an observer grid of {}", width),
             fmt::format("at most {:.0f}", k_most_grid_observers),
             fmt::format("{:.0f} by {:.0f}", columns, rows));
  const glm::dvec2 corner(extent.center().x - 0.5 * columns * width, extent.center().y - 0.5 * rows * width);
  std::vector<GivenObserver> observers;
  const auto total = static_cast<std::uint64_t>(columns * rows);
  for (std::uint64_t row = 0; row < static_cast<std::uint64_t>(rows); ++row) {
    for (std::uint64_t column = 0; column < static_cast<std::uint64_t>(columns); ++column) {
      const glm::dvec2 position(corner.x + (static_cast<double>(column) + 0.5) * width,
                                corner.y + (static_cast<double>(row) + 0.5) * width);
      if (!ground(position)) continue;
      observers.push_back({.source = "--observer-grid",
                           .name = fmt::format("{}-{}", row + 1, column + 1),
                           .position = position});
    }
    report(progress, (row + 1) * static_cast<std::uint64_t>(columns), total);
  }
  if (observers.empty())
    throw Error({.problem = "the observer grid has no position near points of the cloud"});
  return observers;
}

Clearance clearance_of(const Occluders& occluders, const glm::dvec3& eye) {
  const SightEnd end = end_near_surface(occluders, eye);
  // The surface that the eye is on may be as far above it as it is below.
  const double raise = end.own_thickness + 2.0 * k_mesh_contact;
  const glm::dvec3 above_surface = eye + glm::dvec3(0.0, 0.0, raise);
  std::optional<double> below = first_along(occluders, sight_ray(chord_end(above_surface), {0, 0, -1}));
  if (below) below = std::max(*below - raise, 0.0);
  return {below, first_along(occluders, sight_ray(end, {0, 0, 1}))};
}

std::vector<std::string> observer_remarks(const Occluders& occluders, std::span<const Observer> observers) {
  if (occluders.octree().size() == 0 && occluders.options().terrain == nullptr) return {};
  std::vector<std::string> remarks(observers.size());
  in_parallel(observers.size(), 1, [&](std::size_t i) {
    occluders.check_given_up();
    remarks[i] = remark_on(occluders, observers[i]);
  });
  std::erase(remarks, "");
  return remarks;
}

}  // namespace alidade::visibility
