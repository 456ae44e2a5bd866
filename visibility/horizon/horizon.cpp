// SPDX-License-Identifier: MIT
#include "visibility/horizon/horizon.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "base/ray.h"
#include "geo/earth.h"
#include "mesh/triangle_tree.h"
#include "visibility/horizon/near_lines.h"

namespace alidade::visibility {
namespace {

constexpr double k_turn = 360.0, k_quarter = 90.0;

void check_range(bool holds, const char* what, std::string expected, double found) {
  check_that(holds, fmt::format("{} out of range", what), std::move(expected), fmt::format("{}", found));
}

/// Number of steps of this size in a range of degrees.
int whole_steps(const char* what, double range, double step, double least, double most) {
  constexpr double k_slack = 1e-6;
  const double steps = range / step;
  check_range(step >= least && step <= most && !(std::fabs(steps - std::round(steps)) > k_slack * steps),
              what, fmt::format("degrees from {} to {} that divide {} evenly", least, most, range), step);
  return static_cast<int>(std::round(steps));
}

/// All lines from an eye in one azimuth between two elevations.
class SightFan {
 public:
  SightFan(const SightEnd& eye, double azimuth, double bottom, double top)
      : eye_(eye),
        along_(geo::compass_direction(azimuth, 0.0)),
        bottom_(sine_cosine_of_degrees(bottom)),
        top_(sine_cosine_of_degrees(top)) {}

  /// True only if none of them meets a triangle that the eye does not lie on.
  bool is_free(const TriangleTree& mesh) const {
    return !mesh.any([this](const Bounds& box) { return may_reach(box); },
                     [this](const std::array<glm::dvec3, 3>& corners) { return may_reach(corners); });
  }
  /// True only if none of them meets the box of a patch of the terrain.
  bool is_free(const geo::TerrainSurface& terrain) const {
    return !terrain.any([this](const Bounds& box) { return may_reach(box); });
  }

 private:
  /// A position as seen from the eye along the azimuth, metres.
  struct Position {
    double run, aside, rise;

    /// Far more than the error of rounding.
    double slack() const { return 1e-6 * (1.0 + std::fabs(run) + std::fabs(aside) + std::fabs(rise)); }
  };

  Position seen(const glm::dvec3& position) const {
    const glm::dvec3 offset = position - eye_.position;
    return {offset.x * along_.x + offset.y * along_.y, offset.x * along_.y - offset.y * along_.x, offset.z};
  }

  /// Whether the convex hull of positions may reach into the fan: no face of the wedge around the fan
  /// separates them.
  bool may_reach(std::span<const Position> hull) const {
    bool is_behind = true, is_left = true, is_right = true, is_above = true, is_below = true;
    for (const Position& one : hull) {
      const double slack = one.slack();
      is_behind = is_behind && one.run < -slack;
      is_left = is_left && one.aside < -slack;
      is_right = is_right && one.aside > slack;
      is_above = is_above && one.rise * top_.cosine - one.run * top_.sine > slack;
      is_below = is_below && one.rise * bottom_.cosine - one.run * bottom_.sine < -slack;
    }
    return !(is_behind || is_left || is_right || is_above || is_below);
  }

  bool may_reach(const Bounds& box) const {
    std::array<Position, 8> hull;
    for (std::size_t i = 0; i < hull.size(); ++i)
      hull[i] =
          seen({i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z});
    return may_reach(hull);
  }

  /// Tests the section of the triangle with the vertical plane of the fan.
  bool may_reach(const std::array<glm::dvec3, 3>& corners) const {
    if (is_own(corners)) return false;
    std::array<Position, 6> cut;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Position from = seen(corners[i]), to = seen(corners[(i + 1) % 3]);
      if (std::fabs(from.aside) <= from.slack()) cut[count++] = from;
      if ((from.aside < 0.0) == (to.aside < 0.0)) continue;
      const double share = from.aside / (from.aside - to.aside);
      cut[count++] = {from.run + share * (to.run - from.run), 0.0, from.rise + share * (to.rise - from.rise)};
    }
    return count > 0 && may_reach(std::span(cut).first(count));
  }

  /// True only if the eye lies on the triangle.
  bool is_own(const std::array<glm::dvec3, 3>& corners) const {
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    return std::fabs(glm::dot(eye_.position - corners[0], normal)) <
           0.5 * eye_.mesh_contact * glm::length(normal);
  }

  const SightEnd& eye_;
  glm::dvec3 along_;
  SineCosine bottom_, top_;
};

constexpr int k_lines_at_once = 16;

/// The highest blocked line of one azimuth.
struct AzimuthSearch {
  const Occluders& occluders;
  const NearLines& near;
  const SightEnd& eye;
  const ElevationSteps& steps;
  int number;  ///< of the azimuth
  double azimuth, max_distance;

  /// Number of the highest blocked elevation in [low, high].
  std::optional<int> highest(int low, int high) const {
    // Wider fans are hardly ever free.
    constexpr double k_widest_fan = 23.0;  // degrees
    const bool is_narrow = steps.elevation(high) - steps.elevation(low) <= k_widest_fan;
    if (is_narrow && is_free(low, high)) return {};
    if (high - low < k_lines_at_once) return highest_line(low, high);
    const int middle = low + (high - low) / 2;
    const std::optional<int> upper = highest(middle + 1, high);
    return upper ? upper : highest(low, middle);
  }

  SightLine line(int step) const {
    return sight_ray(eye, geo::compass_direction(azimuth, steps.elevation(step)), max_distance);
  }

  /// True only if nothing blocks any line at these elevations.
  bool is_free(int low, int high) const {
    if (!near.are_free(number, low, high)) return false;
    const SightFan fan(eye, azimuth, steps.elevation(low), steps.elevation(high));
    const auto& mesh = occluders.options().mesh;
    const auto& terrain = occluders.options().terrain;
    return (mesh == nullptr || fan.is_free(*mesh)) && (terrain == nullptr || fan.is_free(*terrain));
  }

  std::optional<int> highest_line(int low, int high) const {
    std::array<SightLine, k_lines_at_once> lines;
    std::array<std::uint8_t, k_lines_at_once> answers{};
    const auto count = static_cast<std::size_t>(high - low + 1);
    for (std::size_t i = 0; i < count; ++i) lines[i] = line(low + static_cast<int>(i));
    blocked(occluders, std::span(lines).first(count), std::span(answers).first(count));
    for (int step = high; step >= low; --step)
      if (answers[static_cast<std::size_t>(step - low)] != 0) return step;
    return {};
  }
};

// Members keep the order in which they are inserted.
using Json = nlohmann::ordered_json;

Json point_geometry(const glm::dvec3& position) {
  return {{"type", "Point"}, {"coordinates", {position.x, position.y}}};
}

Json feature(Json geometry, Json properties) {
  return {{"type", "Feature"}, {"geometry", std::move(geometry)}, {"properties", std::move(properties)}};
}

}  // namespace

int azimuths_per_turn(double step) {
  return whole_steps("azimuth step", k_turn, step, 0.001, 120.0);
}

std::vector<HorizonDirection> horizon(const Occluders& occluders, const SightEnd& eye,
                                      const HorizonOptions& options, const Progress& progress) {
  const int per_turn = azimuths_per_turn(options.step);
  ElevationSteps steps{whole_steps("elevation resolution", k_quarter, options.resolution, 0.0001, 10.0)};
  const auto in_quarter = [](double elevation) { return elevation >= -k_quarter && elevation <= k_quarter; };
  check_range(in_quarter(options.elevation_min), "minimum elevation", "-90 to 90", options.elevation_min);
  check_range(in_quarter(options.elevation_max), "maximum elevation", "-90 to 90", options.elevation_max);
  check_range(options.max_distance >= 0.0, "maximum distance", "at least 0", options.max_distance);
  const double from = options.azimuth_min;
  double width = options.azimuth_max - from;
  if (width <= 0.0) width += k_turn;
  check_range(std::fabs(from) <= 2.0 * k_turn && width > 0.0, "azimuth", "-720 to 720", from);

  // Limits this near to a multiple of a step count as equal to it.
  constexpr double k_slack = 1e-9;
  const auto step_below = [&](double degrees, double range, int count) {
    return static_cast<int>(std::floor(degrees / range * count + k_slack));
  };
  steps.low = -step_below(-options.elevation_min, k_quarter, steps.per_quarter);
  steps.high = step_below(options.elevation_max, k_quarter, steps.per_quarter);
  const int first = -step_below(-from, k_turn, per_turn);
  const int last = step_below(from + width, k_turn, per_turn);
  const AzimuthSteps azimuths{per_turn, first, std::clamp(last - first + 1, 0, per_turn)};

  std::vector<HorizonDirection> directions(static_cast<std::size_t>(azimuths.count));
  for (std::size_t i = 0; i < directions.size(); ++i)
    directions[i].azimuth = azimuths.azimuth(static_cast<int>(i));
  if (steps.high < steps.low) return directions;
  make_ray(eye.position, {0.0, 0.0, 1.0});  // an eye that is not finite is an error
  const NearLines near(occluders, eye, azimuths, steps, k_lines_at_once);
  constexpr std::size_t k_azimuths_at_once = 64;
  for (std::size_t begin = 0; begin < directions.size(); begin += k_azimuths_at_once) {
    report(progress, begin, directions.size());
    in_parallel(std::min(k_azimuths_at_once, directions.size() - begin), 1, [&](std::size_t number) {
      const std::size_t i = begin + number;
      HorizonDirection& direction = directions[i];
      const AzimuthSearch search{
          occluders, near, eye, steps, static_cast<int>(i), direction.azimuth, options.max_distance};
      const std::optional<int> step = search.highest(steps.low, steps.high);
      if (!step) return;
      direction.elevation = steps.elevation(*step);
      direction.blocker = first_blocker(occluders, search.line(*step));
    });
  }
  report(progress, directions.size(), directions.size());
  return directions;
}

SkyShares sky_above(std::span<const HorizonDirection> horizon) {
  double cosine_weighted = 0.0, solid_angle = 0.0;
  for (const HorizonDirection& direction : horizon) {
    const SineCosine height = sine_cosine_of_degrees(std::max(direction.elevation.value_or(0.0), 0.0));
    cosine_weighted += height.cosine * height.cosine;
    solid_angle += 1.0 - height.sine;
  }
  const auto count = static_cast<double>(horizon.size());
  return {cosine_weighted / count, solid_angle / count};
}

std::string horizon_csv(std::span<const HorizonDirection> horizon) {
  std::string text = "azimuth,elevation,distance,point_id,x,y,z,unscanned\n";
  for (const HorizonDirection& direction : horizon) {
    if (!direction.blocker) {
      text += fmt::format("{:.6g},,,,,,,\n", direction.azimuth);
      continue;
    }
    const Blocker& blocker = *direction.blocker;
    text += fmt::format("{:.6g},{:.6g},{:.4f},{},{:.12g},{:.12g},{:.12g},{}\n", direction.azimuth,
                        *direction.elevation, blocker.distance,
                        blocker.is_mesh() ? "" : std::to_string(blocker.point_id), blocker.position.x,
                        blocker.position.y, blocker.position.z,
                        direction.unscanned ? fmt::format("{:.4f}", *direction.unscanned) : "");
  }
  return text;
}

std::vector<glm::dvec3> horizon_positions(std::span<const HorizonDirection> horizon,
                                          const HorizonFacts& facts) {
  std::vector<glm::dvec3> positions;
  for (const HorizonDirection& direction : horizon)
    if (direction.blocker) positions.push_back(direction.blocker->position);
  positions.push_back(facts.eye);
  return positions;
}

std::string horizon_geojson(std::span<const HorizonDirection> horizon, const HorizonFacts& facts,
                            const std::optional<std::vector<glm::dvec3>>& on_globe) {
  const std::vector<glm::dvec3> positions = on_globe ? *on_globe : horizon_positions(horizon, facts);
  assert(positions.size() == horizon_positions(horizon, facts).size());
  // One feature per line, for readers and for diff.
  std::string text = "{\"type\": \"FeatureCollection\",\n";
  if (!on_globe) text += "\"coordinate_system\": \"x and y of the cloud, not longitude and latitude\",\n";
  text += "\"features\": [\n";
  Json eye{{"kind", "observer"},
           {"z", facts.eye.z},
           {"sky_view_factor", facts.sky.cosine_weighted},
           {"sky_solid_angle", facts.sky.solid_angle}};
  if (facts.above_line) {
    eye["sky_view_factor_above_line"] = facts.above_line->cosine_weighted;
    eye["sky_solid_angle_above_line"] = facts.above_line->solid_angle;
  }
  text += feature(point_geometry(positions.back()), std::move(eye)).dump();
  std::size_t next = 0;
  for (const HorizonDirection& direction : horizon) {
    Json geometry = nullptr;
    Json properties{{"kind", "horizon"}, {"azimuth", direction.azimuth}};
    if (direction.blocker) {
      geometry = point_geometry(positions[next++]);
      properties["elevation"] = *direction.elevation;
      properties["distance"] = direction.blocker->distance;
      properties["point_id"] = direction.blocker->is_mesh() ? Json() : Json(direction.blocker->point_id);
      properties["z"] = direction.blocker->position.z;
      if (direction.unscanned) properties["unscanned"] = *direction.unscanned;
    }
    text += ",\n" + feature(std::move(geometry), std::move(properties)).dump();
  }
  return text + "\n]}\n";
}

}  // namespace alidade::visibility
