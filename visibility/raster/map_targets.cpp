// SPDX-License-Identifier: MIT
#include "visibility/raster/map_targets.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/parallel.h"
#include "geo/raster.h"
#include "octree/query.h"

namespace alidade::visibility {
namespace {

/// Levels of the widest block with at most `most_positions`.
int levels_of_block(int positions_across, std::size_t most_positions) {
  const auto per_cell =
      static_cast<std::size_t>(positions_across) * static_cast<std::size_t>(positions_across);
  int levels = 8;
  while (levels > 0 && (per_cell << (2 * levels)) > most_positions) --levels;
  return levels;
}

std::size_t blocks_along(int cells, int levels) {
  return (static_cast<std::size_t>(cells) + (std::size_t{1} << levels) - 1) >> levels;
}

/// Every second bit of a number, from its lowest: one coordinate of a cell on the Z curve.
int every_second_bit(std::uint32_t number) {
  constexpr int k_most_bits = 16;
  int coordinate = 0;
  for (int bit = 0; bit < k_most_bits; ++bit)
    coordinate |= static_cast<int>((number >> (2 * bit)) & 1u) << bit;
  return coordinate;
}

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

SightEnd end_on_ground(const Occluders& occluders, const glm::dvec3& position) {
  constexpr std::size_t k_candidates = 8;
  constexpr double k_flat = 0.5;  // of the normal's z: slopes up to 60 degrees
  if (!occluders.has_surfaces()) return {position};
  const PointQuery query{.radius = occluders.largest_radius(), .k = k_candidates};
  std::optional<SightEnd> end;
  for (const PointHit& hit : find(occluders.octree(), position, query)) {
    const PointSurface surface = occluders.surface(hit.point_id);
    if (!surface.exists || std::fabs(surface.normal.z) < k_flat) continue;
    const glm::dvec3 center = hit.position - surface.height * surface.normal;
    const glm::dvec2 way = glm::dvec2(position) - glm::dvec2(center);
    const double sheet = center.z - (way.x * surface.normal.x + way.y * surface.normal.y) / surface.normal.z;
    if (std::fabs(sheet - position.z) > occluders.typical_radius()) continue;
    // The own surface of the position is that of the points of this sheet.
    const SightEnd on_point = end_on_point(occluders, hit.point_id, hit.position, hit.position);
    if (!end) {
      const double height = std::max(position.z, sheet - surface.thickness) + surface.thickness;
      end = {{position.x, position.y, height}, on_point.own_reach, 0.0};
    }
    const double above = std::fabs((end->position.z - sheet) * surface.normal.z);
    end->own_thickness = std::max(end->own_thickness, above + on_point.own_thickness);
  }
  return end.value_or(SightEnd{position});
}

MapTargets::MapTargets(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
                       int positions_across, std::size_t most_positions)
    : occluders_(occluders),
      ground_(ground),
      grid_(grid),
      positions_across_(positions_across),
      block_levels_(levels_of_block(positions_across, most_positions)) {}

std::size_t MapTargets::block_count() const {
  return blocks_along(grid_.columns, block_levels_) * blocks_along(grid_.rows, block_levels_);
}

std::vector<std::size_t> MapTargets::cells(std::size_t number) const {
  const std::size_t blocks = blocks_along(grid_.columns, block_levels_);
  const int first_column = static_cast<int>(number % blocks) << block_levels_,
            first_row = static_cast<int>(number / blocks) << block_levels_;
  std::vector<std::size_t> cells;
  for (std::uint32_t i = 0; i < (std::uint32_t{1} << (2 * block_levels_)); ++i) {
    // Sums of two numbers below 2^31: they must not be taken as int.
    const std::int64_t column = std::int64_t{first_column} + every_second_bit(i),
                       row = std::int64_t{first_row} + every_second_bit(i >> 1);
    if (column < grid_.columns && row < grid_.rows)
      cells.push_back(grid_.index(static_cast<int>(column), static_cast<int>(row)));
  }
  return cells;
}

MapBlock MapTargets::block(std::size_t number) const {
  MapBlock block{cells(number), {}};
  const auto across = static_cast<std::size_t>(positions_across_), per_cell = across * across;
  const auto columns = static_cast<std::size_t>(grid_.columns);
  std::vector<std::optional<MapTarget>> found(block.cells.size() * per_cell);
  in_parallel(found.size(), 64, [&](std::size_t i) {
    const std::size_t cell = i / per_cell, part = i % per_cell;
    const glm::dvec2 middle = grid_.center(static_cast<int>(block.cells[cell] % columns),
                                           static_cast<int>(block.cells[cell] / columns));
    const glm::dvec2 share =
        (glm::dvec2(part % across, part / across) + 0.5) / static_cast<double>(positions_across_) -
        glm::dvec2(0.5);
    const glm::dvec2 position = middle + share * grid_.cell_size;
    // Visibility on unscanned ground is unknown.
    const std::optional<double> height = ground_.is_scanned(position) ? ground_.at(position) : std::nullopt;
    if (height) found[i] = MapTarget{cell, end_on_ground(occluders_, {position.x, position.y, *height})};
  });
  for (const std::optional<MapTarget>& target : found) {
    if (target) block.targets.push_back(*target);
  }
  return block;
}

MapObserver::MapObserver(const Occluders& occluders, const Observer& observer)
    : eye_(end_near_surface(occluders, observer.position)),
      view_(observer),
      azimuths_(at_any_elevation(observer)),
      max_distance_(observer.max_distance),
      lower_slope_(slope_of(observer.elevation_min)),
      upper_slope_(slope_of(observer.elevation_max)) {}

std::optional<HeightRange> MapObserver::heights_in_view(const glm::dvec3& foot,
                                                        const HeightRange& tested) const {
  const glm::dvec3 offset = foot - eye_.position;
  const double run_sq = offset.x * offset.x + offset.y * offset.y, run = std::sqrt(run_sq);
  const double reach_sq = max_distance_ * max_distance_ - run_sq;
  if (!azimuths_.contains({offset.x, offset.y, 0.0}) || reach_sq < 0.0) return std::nullopt;
  const double reach = std::sqrt(reach_sq);
  // A run of 0 times an infinite slope would be NaN.
  const double lowest = std::isinf(lower_slope_) ? lower_slope_ : run * lower_slope_,
               highest = std::isinf(upper_slope_) ? upper_slope_ : run * upper_slope_;
  HeightRange range{std::max(tested.low, std::max(lowest, -reach) - offset.z),
                    std::min(tested.high, std::min(highest, reach) - offset.z)};
  // At limits that depend on rounding, looks_at() decides.
  if (looks_at(foot + glm::dvec3(0.0, 0.0, tested.low))) {
    range.low = tested.low;
    range.high = std::max(range.high, tested.low);
  }
  if (!(range.low <= range.high)) return std::nullopt;
  return range;
}

Bounds area_in_reach(const Bounds& area, std::span<const Observer> observers, const std::string& who) {
  Bounds reached;
  for (const Observer& observer : observers) {
    const glm::dvec3 reach(observer.max_distance);
    reached.grow(geo::cropped(area, {observer.position - reach, observer.position + reach}));
  }
  check_that(!reached.empty(), "no " + who + " reaches the map",
             "an " + who + " near the cloud, a larger maximum distance, or another area");
  return reached;
}

double usual_resolution(const Bounds& area, double finest) {
  constexpr double k_cells = 1000.0;
  const glm::dvec3 size = area.size();
  const double least = std::max(std::max(size.x, size.y) / k_cells, finest);
  if (!(least > 0.0)) return 1.0;
  const double exponent = std::floor(std::log10(least));
  const double power = std::pow(10.0, std::fabs(exponent));
  for (const double mantissa : {1.0, 2.0, 5.0}) {
    const double size_of_cell = exponent < 0.0 ? mantissa / power : mantissa * power;
    if (size_of_cell >= least) return size_of_cell;
  }
  return exponent < 0.0 ? 10.0 / power : 10.0 * power;
}

}  // namespace alidade::visibility
