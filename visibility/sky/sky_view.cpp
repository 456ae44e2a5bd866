// SPDX-License-Identifier: MIT
#include "visibility/sky/sky_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/parallel.h"
#include "geo/earth.h"

namespace alidade::visibility {
namespace {

glm::dvec3 spiral_direction(int i, double height) {
  const SineCosine turn = sine_cosine_of_turns(golden_turns(i));
  const double run = std::sqrt(1.0 - height * height);
  return {run * turn.sine, run * turn.cosine, height};
}

constexpr std::size_t k_targets_at_once = 1024;
/// The cosine of 20 degrees: the lower side of a surface this level sees less than 3 % of the sky.
constexpr double k_level = 0.93969262078590838;

/// What a target sees from each of its sides.
struct Sides {
  double front = 0.0, back = 0.0;
};

double wider_side(const SkyTarget& target, const Sides& sides) {
  if (!target.has_surface() || target.is_front_open) return sides.front;
  return std::max(sides.front, sides.back);
}

void check_directions(int count) {
  check_that(count >= 1 && count <= k_most_sky_directions, "number of sky directions out of range",
             "1 to " + std::to_string(k_most_sky_directions), std::to_string(count));
}

/// Sums over the free lines of every target, in the order of the directions.
std::vector<Sides> both_sides(const Occluders& occluders, std::span<const SkyTarget> targets,
                              const SkyViewOptions& options) {
  const int most = options.directions;
  check_directions(most);
  const bool is_horizontal = options.receiver == SkyReceiver::horizontal;
  const std::vector<glm::dvec3> directions =
      is_horizontal ? cosine_sky_directions(most) : even_sky_directions(most);
  std::vector<Sides> sides(targets.size());
  std::vector<SightLine> lines(targets.size());
  std::vector<std::uint8_t> answers(targets.size());
  for (const glm::dvec3& direction : directions) {
    const auto is_ahead = [&](const SkyTarget& target) {
      return !target.has_surface() || glm::dot(direction, target.normal) > 0.0;
    };
    in_parallel(targets.size(), k_targets_at_once, [&](std::size_t i) {
      const SkyTarget& target = targets[i];
      lines[i] = sight_ray(is_ahead(target) ? target.front : target.back, direction, options.max_distance);
    });
    blocked(occluders, lines, answers);
    in_parallel(targets.size(), k_targets_at_once, [&](std::size_t i) {
      if (answers[i] != 0) return;
      const SkyTarget& target = targets[i];
      const bool ahead = is_ahead(target);
      double weight = 1.0 / most;
      if (!is_horizontal)
        weight *= 2.0 * (target.has_surface() ? std::fabs(glm::dot(direction, target.normal)) : direction.z);
      (ahead ? sides[i].front : sides[i].back) += weight;
    });
  }
  return sides;
}

/// The sky-view factor as an integral above the horizons of even azimuths.
double view_above_horizons(const geo::TerrainSurface& terrain, const SkyTarget& target,
                           const SkyViewOptions& options) {
  const glm::dvec3 up(0.0, 0.0, 1.0), surface = target.has_surface() ? target.normal : up;
  const glm::dvec3 normal = options.receiver == SkyReceiver::surface ? surface : up;
  const double width = 360.0 / options.directions;
  double sum = 0.0;
  for (int i = 0; i < options.directions; ++i) {
    const glm::dvec2 direction(geo::compass_direction((i + 0.5) * width, 0.0));
    const double facing = facing_slope(surface, direction);
    if (std::isinf(facing)) continue;
    const double slope = terrain.horizon_slope(target.front.position, direction, facing);
    const double elevation = std::atan(slope) * 180.0 / std::numbers::pi;
    sum += std::max(0.0, glm::dot(normal, direction_integral({i * width, (i + 1) * width, elevation, 90.0})));
  }
  return sum / std::numbers::pi;
}

}  // namespace

glm::dvec3 direction_integral(const SkyCell& cell) {
  constexpr double k_degree = std::numbers::pi / 180.0;
  const SineCosine west = sine_cosine_of_degrees(cell.azimuth_min),
                   east = sine_cosine_of_degrees(cell.azimuth_max),
                   low = sine_cosine_of_degrees(cell.elevation_min),
                   high = sine_cosine_of_degrees(cell.elevation_max);
  // Integrals of cos^2 and of sin cos over the elevations.
  const double flat = 0.5 * ((cell.elevation_max - cell.elevation_min) * k_degree + high.sine * high.cosine -
                             low.sine * low.cosine),
               steep = 0.5 * (high.sine * high.sine - low.sine * low.sine);
  return {flat * (west.cosine - east.cosine), flat * (east.sine - west.sine),
          steep * (cell.azimuth_max - cell.azimuth_min) * k_degree};
}

std::vector<glm::dvec3> even_sky_directions(int count) {
  std::vector<glm::dvec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) directions.push_back(spiral_direction(i, (i + 0.5) / count));
  return directions;
}

std::vector<glm::dvec3> cosine_sky_directions(int count) {
  std::vector<glm::dvec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    directions.push_back(spiral_direction(i, std::sqrt(1.0 - (i + 0.5) / count)));
  return directions;
}

bool has_horizons(const Occluders& occluders, double max_distance) {
  const OccluderOptions& options = occluders.options();
  return occluders.octree().size() == 0 && options.mesh == nullptr && options.terrain != nullptr &&
         std::isinf(max_distance);
}

double facing_slope(const glm::dvec3& normal, const glm::dvec2& direction) {
  const double towards = normal.x * direction.x + normal.y * direction.y;
  if (towards >= 0.0 && (towards > 0.0 || normal.z > 0.0)) return 0.0;
  return normal.z > 0.0 ? -towards / normal.z : std::numeric_limits<double>::infinity();
}

SkyTarget target_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                          const std::optional<glm::dvec3>& outward) {
  SkyTarget target;
  const PointSurface surface = occluders.surface(point_id);
  if (surface.exists) {
    const bool turned = glm::dot(surface.normal, outward.value_or(glm::dvec3(0.0, 0.0, 1.0))) < 0.0;
    target.normal = turned ? -surface.normal : surface.normal;
    target.is_front_open = outward.has_value();
  }
  // Far enough away to be outside of the sheet, near enough to lose no digits.
  const glm::dvec3 aside = surface.exists ? target.normal : glm::dvec3(0.0, 0.0, 1.0);
  constexpr double k_aside = 1000.0;
  target.front = end_on_point(occluders, point_id, position, position + k_aside * aside);
  target.back = end_on_point(occluders, point_id, position, position - k_aside * aside);
  return target;
}

SkyTarget target_in_open(const SightEnd& end) {
  SkyTarget target;
  target.front = target.back = end;
  return target;
}

void sky_views(const Occluders& occluders, std::span<const SkyTarget> targets, const SkyViewOptions& options,
               std::span<float> views) {
  assert(targets.size() == views.size());
  if (has_horizons(occluders, options.max_distance)) {
    check_directions(options.directions);
    in_parallel(targets.size(), 16, [&](std::size_t i) {
      views[i] = static_cast<float>(view_above_horizons(*occluders.options().terrain, targets[i], options));
    });
    return;
  }
  const std::vector<Sides> sides = both_sides(occluders, targets, options);
  in_parallel(targets.size(), k_targets_at_once,
              [&](std::size_t i) { views[i] = static_cast<float>(wider_side(targets[i], sides[i])); });
}

void find_open_sides(const Occluders& occluders, int directions, std::span<SkyTarget> targets) {
  std::vector<SkyTarget> undecided;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    SkyTarget& target = targets[i];
    if (!target.has_surface() || target.is_front_open) continue;
    if (target.normal.z < 0.0) {
      std::swap(target.front, target.back);
      target.normal = -target.normal;
    }
    target.is_front_open = target.normal.z >= k_level;
    if (target.is_front_open) continue;
    undecided.push_back(target);
    indices.push_back(i);
  }
  const std::vector<Sides> sides = both_sides(occluders, undecided, {.directions = directions});
  for (std::size_t i = 0; i < undecided.size(); ++i) {
    SkyTarget& target = targets[indices[i]];
    if (sides[i].back > sides[i].front) {
      std::swap(target.front, target.back);
      target.normal = -target.normal;
    }
    target.is_front_open = true;
  }
}

SkyShares sky_shares(const Occluders& occluders, const SightEnd& eye, int directions, double max_distance) {
  check_directions(directions);
  const auto free_share = [&](const std::vector<glm::dvec3>& towards) {
    std::vector<SightLine> lines;
    lines.reserve(towards.size());
    for (const glm::dvec3& direction : towards) lines.push_back(sight_ray(eye, direction, max_distance));
    std::vector<std::uint8_t> answers(lines.size());
    blocked(occluders, lines, answers);
    return static_cast<double>(std::count(answers.begin(), answers.end(), 0)) /
           static_cast<double>(answers.size());
  };
  return {free_share(cosine_sky_directions(directions)), free_share(even_sky_directions(directions))};
}

}  // namespace alidade::visibility
