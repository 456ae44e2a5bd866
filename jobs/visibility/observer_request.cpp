// SPDX-License-Identifier: MIT
#include "jobs/visibility/observer_request.h"

#include <fmt/format.h>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/input_file.h"
#include "visibility/read_observers.h"

namespace alidade::jobs {
namespace {

constexpr std::size_t k_most_lines = 8;  ///< said about observers

/// Two angles separated by a comma.
std::pair<double, double> parse_angles(const std::string& text, double least, double most) {
  const std::vector<std::string> words = split_list(text, 2, "two angles separated by a comma");
  return {parse_number(words[0], least, most), parse_number(words[1], least, most)};
}

void add_view(const Fields& group, visibility::ObserverDefaults& defaults) {
  group.value("--max-distance,--md,--max_distance", "LENGTH",
              "largest distance along the line of sight (default: inf)", defaults.max_distance,
              parse_distance_limit);
  const Field azimuths =
      group.value("--horizontal-fov", "A0,A1",
                  "field of view in degrees clockwise from north (+y), from A0 clockwise to A1: 350,10 looks "
                  "north (default: 0,360)",
                  [&defaults](const std::string& text) {
                    const auto [from, to] = parse_angles(text, -360.0, 720.0);
                    if (from == to)
                      throw UsageError("invalid value; expected two different angles, found '" + text + "'");
                    defaults.azimuth_min = from;
                    defaults.azimuth_max = to;
                  });
  group.excludes(azimuths).value(
      "--direction_range", "D0,D1", "the same as in r.viewshed: from D0 to D1 counterclockwise, 0 is east",
      [&defaults](const std::string& text) {
        constexpr double k_north = 90.0;
        const auto [from, to] = parse_angles(text, -360.0, 360.0);
        if (from >= to)
          throw UsageError("limits out of order; expected the smaller angle first, found '" + text + "'");
        defaults.azimuth_min = k_north - to;
        defaults.azimuth_max = k_north - from;
      });
  group.value(
      "--vertical-fov", "E0,E1", "field of view in degrees above the horizontal (default: -90,90)",
      [&defaults](const std::string& text) {
        const auto [low, high] = parse_angles(text, -90.0, 90.0);
        if (low > high)
          throw UsageError("limits out of order; expected the lower angle first, found '" + text + "'");
        defaults.elevation_min = low;
        defaults.elevation_max = high;
      });
}

/// The observers that were given, then those of the file.
std::vector<visibility::GivenObserver> read_given(const ObserverRequest& request, const Crs& crs) {
  const geo::ObserverReference reference{
      .given = request.reference, .cloud = crs, .option = request.reference_option};
  std::vector<visibility::GivenObserver> given = request.positions;
  if (!request.reference.empty() && !given.empty()) visibility::to_cloud_reference(given, "", reference);
  if (request.file.empty()) return given;
  const std::vector<visibility::GivenObserver> read = visibility::read_observers(request.file, reference);
  given.insert(given.end(), read.begin(), read.end());
  return given;
}

/// Errors: an observer is so far away from the cloud that its coordinates are probably wrong; with a probable
/// reason.
void check_far_observers(std::span<const visibility::GivenObserver> given, const Bounds& area) {
  if (area.empty()) return;
  const glm::dvec2 low(area.min), high(area.max);
  const double far = 10.0 * glm::length(high - low) + 1000.0;
  const auto distance = [&](const glm::dvec2& position) {
    return glm::length(glm::max(glm::max(low - position, position - high), glm::dvec2(0.0)));
  };
  for (const visibility::GivenObserver& one : given) {
    const glm::dvec2& position = one.position;
    if (distance(position) <= far) continue;
    const bool is_exchanged = distance({position.y, position.x}) <= far;
    const bool are_degrees = std::fabs(position.x) <= 180.0 && std::fabs(position.y) <= 180.0;
    throw Error(one.source, {},
                fmt::format("the observer is {:.0f} outside of the cloud", distance(position)),
                std::string(is_exchanged ? "x before y: the coordinates seem to be exchanged"
                            : are_degrees
                                ? "coordinates of the cloud, or --observers-crs EPSG:4326 for longitude and "
                                  "latitude, x first"
                                : "coordinates in the cloud's reference system, or --observers-crs") +
                    "; --anywhere accepts it",
                fmt::format("{}, {}; the cloud reaches from {:.0f}, {:.0f} to {:.0f}, {:.0f}", position.x,
                            position.y, low.x, low.y, high.x, high.y));
  }
}

/// Notes where the first observers are, and what is below and above them.
void note_positions(std::span<const visibility::Observer> observers, const visibility::Occluders& occluders,
                    Listener& listener) {
  const auto distance = [](const std::optional<double>& length, const char* with, const char* without) {
    return length ? fmt::format("{:.2f} {}", *length, with) : std::string(without);
  };
  for (const visibility::Observer& one : observers.first(std::min(observers.size(), k_most_lines))) {
    const visibility::Clearance clearance = visibility::clearance_of(occluders, one.position);
    listener.note(fmt::format("{}: eye at {:.3f}, {:.3f}, {:.3f}; {}, {}", one.name, one.position.x,
                              one.position.y, one.position.z,
                              distance(clearance.below, "above what is below it", "nothing below it"),
                              distance(clearance.above, "below what is overhead", "nothing overhead")));
  }
  if (observers.size() > k_most_lines)
    listener.note(fmt::format("and {} more observers", observers.size() - k_most_lines));
}

}  // namespace

void add_observer_positions(const Fields& fields, ObserverRequest& request) {
  const Fields group = fields.group(k_observer_group);
  group.values(
      "--observer", "X,Y[,Z]",
      "position of the eye, or with --observer-height the ground position below it; without Z the ground is "
      "found in the cloud; repeatable",
      [&request](const std::string& text) { request.positions.push_back(visibility::parse_observer(text)); });
  group.file("--observers", "FILE",
             "observers from a file: CSV with the header "
             "x,y[,z][,name][,height][,azimuth_min][,azimuth_max][,elevation_min][,elevation_max][,max_"
             "distance], or points of GeoJSON, GeoPackage or Shapefile with attributes of these names",
             request.file);
  group.value("--observers-crs", "SYSTEM|cloud",
              "reference system of the observers, such as EPSG:4326 (x is east), overriding their file; "
              "cloud: the cloud's (default: the file's, for CSV and --observer the cloud's)",
              [&request](const std::string& text) {
                if (text.empty()) throw UsageError("missing value; expected a reference system");
                request.reference = text;
              });
  group.flag("--anywhere", "accept observers far outside of the cloud, which are otherwise errors",
             request.anywhere);
  group.number("--observer-grid", "LENGTH",
               "an observer on the ground in every square cell of this width over the cloud's extent",
               request.grid, 1e-3, 1e9);
  group.number(
      "--observer-height,--oz,--observer_elevation", "LENGTH",
      "height of the eye above the foot (default: 0 for observers with a z, 2 for those on the ground)",
      request.defaults.height, 0.0, 1e6);
}

void add_observer_fields(const Fields& fields, ObserverRequest& request) {
  add_observer_positions(fields, request);
  add_view(fields.group(k_observer_group), request.defaults);
}

void add_target_height(const Fields& fields, std::optional<double>& height) {
  fields.number("--target-height,--tz,--target_elevation", "LENGTH",
                "height of the target above the ground (default: 0)", height, 0.0, 1e6);
}

void check_given(const ObserverRequest& request) {
  if (request.positions.empty() && request.file.empty() && !request.grid)
    throw input_error("missing observers", "--observer, --observers or --observer-grid");
  if (!request.file.empty()) InputFile{request.file};
}

std::vector<visibility::Observer> load_observers(const ObserverRequest& request, const VisibilityCloud& cloud,
                                                 Listener& listener, const visibility::GroundHeight& ground) {
  check_given(request);
  std::vector<visibility::GivenObserver> given = read_given(request, cloud.cloud.cloud.crs);
  const bool needs_ground =
      request.grid || std::ranges::any_of(given, [](const visibility::GivenObserver& one) { return !one.z; });
  if (!request.anywhere) check_far_observers(given, cloud.area());
  std::optional<visibility::Ground> own_ground;
  if (needs_ground && !ground) own_ground = find_ground(cloud, {}, listener);
  const visibility::GroundHeight height_at =
      ground ? ground : [&](const glm::dvec2& position) { return own_ground->at(position); };
  if (request.grid) {
    const auto grid = in_stage(listener, "placing observers", "cells", [&](const Progress& progress) {
      return visibility::observer_grid(cloud.area(), *request.grid, height_at, progress);
    });
    given.insert(given.end(), grid.begin(), grid.end());
  }
  return visibility::place_observers(given, request.defaults, height_at);
}

void say_observer_remarks(std::span<const visibility::Observer> observers, const VisibilityCloud& cloud,
                          Listener& listener) {
  if (!listener.is_listening()) return;
  if (!observers.empty() && observers.front().is_placed)
    note_positions(observers, *cloud.occluders, listener);
  const std::vector<std::string> remarks = visibility::observer_remarks(*cloud.occluders, observers);
  for (std::size_t i = 0; i < std::min(remarks.size(), k_most_lines); ++i) listener.warn(remarks[i]);
  if (remarks.size() > k_most_lines)
    listener.warn(fmt::format("and {} more observers with warnings", remarks.size() - k_most_lines));
}

}  // namespace alidade::jobs
