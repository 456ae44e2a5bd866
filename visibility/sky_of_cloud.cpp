// SPDX-License-Identifier: MIT
#include "visibility/sky_of_cloud.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "octree/error.h"
#include "visibility/map_targets.h"
#include "visibility/point_blocks.h"

namespace alidade {
namespace {

constexpr std::size_t k_targets_at_once = 1 << 16;
constexpr float k_nothing = std::numeric_limits<float>::quiet_NaN();

std::optional<glm::dvec3> outward(std::span<const glm::vec3> normals, std::uint64_t point_id) {
  if (normals.empty()) return {};
  const glm::dvec3 normal(normals[point_id]);
  const bool says_something = std::isfinite(normal.x) && std::isfinite(normal.y) && std::isfinite(normal.z) &&
                              normal != glm::dvec3(0.0);
  if (!says_something) return {};
  return normal;
}

/// Calls answer(targets, points) for all points, a block at a time.
template <class Answer>
void for_each_point_target(const Occluders& occluders, std::span<const glm::vec3> normals,
                           const Progress& progress, const Answer& answer) {
  const TreeView& tree = occluders.octree().view();
  if (!normals.empty() && normals.size() != tree.point_count) {
    throw Error({.problem = "there is not one normal for every point",
                 .expected = std::to_string(tree.point_count),
                 .found = std::to_string(normals.size())});
  }
  std::vector<SkyTarget> targets;
  std::uint64_t done = 0;
  report(progress, done, tree.point_count);
  for_each_point_block(tree, k_targets_at_once, [&](std::span<const PlacedPoint> points) {
    targets.resize(points.size());
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      targets[i] = target_on_point(occluders, points[i].point_id, points[i].position,
                                   outward(normals, points[i].point_id));
    });
    answer(std::span<SkyTarget>(targets), points);
    done += points.size();
    report(progress, done, tree.point_count);
  });
}

/// Calls answer(targets, cells) for all cells that have ground, a block at a time; cells by their number in
/// the map.
template <class Answer>
void for_each_ground_target(const Occluders& occluders, const Ground& ground, const RasterGrid& grid,
                            double height, const Progress& progress, const Answer& answer) {
  if (!(height >= 0.0) || !std::isfinite(height)) {
    throw Error({.problem = "height above the ground is out of range",
                 .expected = "0 or more",
                 .found = std::to_string(height)});
  }
  const MapTargets places(occluders, ground, grid, 1);
  std::vector<SkyTarget> targets;
  std::vector<std::size_t> cells;
  std::uint64_t done = 0;
  report(progress, done, grid.size());
  for (std::size_t number = 0; number < places.block_count(); ++number) {
    const MapBlock block = places.block(number);
    targets.clear();
    cells.clear();
    for (const MapTarget& target : block.targets) {
      targets.push_back(target_in_open(raised(target.foot, height)));
      cells.push_back(block.cells[target.cell]);
    }
    answer(std::span<SkyTarget>(targets), std::span<const std::size_t>(cells));
    done += block.cells.size();
    report(progress, done, grid.size());
  }
}

}  // namespace

std::vector<float> point_sky_views(const Occluders& occluders, std::span<const glm::vec3> normals,
                                   const SkyViewOptions& options, const Progress& progress) {
  std::vector<float> views(occluders.octree().size());
  std::vector<float> of_block;
  for_each_point_target(occluders, normals, progress,
                        [&](std::span<SkyTarget> targets, std::span<const PlacedPoint> points) {
                          of_block.resize(targets.size());
                          sky_views(occluders, targets, options, of_block);
                          for (std::size_t i = 0; i < points.size(); ++i)
                            views[points[i].point_id] = of_block[i];
                        });
  return views;
}

std::vector<SunHours> point_sun_hours(const Occluders& occluders, std::span<const glm::vec3> normals,
                                      std::span<const SunBin> bins, const SunHoursOptions& options,
                                      const Progress& progress) {
  constexpr int k_side_directions = 64;
  std::vector<SunHours> hours(occluders.octree().size());
  std::vector<SunHours> of_block;
  for_each_point_target(occluders, normals, progress,
                        [&](std::span<SkyTarget> targets, std::span<const PlacedPoint> points) {
                          find_open_sides(occluders, k_side_directions, targets);
                          of_block.resize(targets.size());
                          sun_hours(occluders, targets, bins, options, of_block);
                          for (std::size_t i = 0; i < points.size(); ++i)
                            hours[points[i].point_id] = of_block[i];
                        });
  return hours;
}

Raster<float> ground_sky_views(const Occluders& occluders, const Ground& ground, const RasterGrid& grid,
                               double height, const SkyViewOptions& options, const Progress& progress) {
  check_map_memory(grid, 1);
  Raster<float> views(grid, k_nothing);
  SkyViewOptions facing_up = options;
  facing_up.receiver = SkyReceiver::horizontal;
  std::vector<float> of_block;
  for_each_ground_target(occluders, ground, grid, height, progress,
                         [&](std::span<SkyTarget> targets, std::span<const std::size_t> cells) {
                           of_block.resize(targets.size());
                           sky_views(occluders, targets, facing_up, of_block);
                           for (std::size_t i = 0; i < cells.size(); ++i)
                             views.values[cells[i]] = of_block[i];
                         });
  return views;
}

SunMaps ground_sun_hours(const Occluders& occluders, const Ground& ground, const RasterGrid& grid,
                         double height, std::span<const SunBin> bins, const SunHoursOptions& options,
                         const Progress& progress) {
  check_map_memory(grid, 2);
  SunMaps maps{Raster<float>(grid, k_nothing), Raster<float>(grid, k_nothing)};
  std::vector<SunHours> of_block;
  for_each_ground_target(occluders, ground, grid, height, progress,
                         [&](std::span<SkyTarget> targets, std::span<const std::size_t> cells) {
                           of_block.resize(targets.size());
                           sun_hours(occluders, targets, bins, options, of_block);
                           for (std::size_t i = 0; i < cells.size(); ++i) {
                             maps.hours.values[cells[i]] = of_block[i].hours;
                             maps.kilowatt_hours.values[cells[i]] = of_block[i].kilowatt_hours;
                           }
                         });
  return maps;
}

}  // namespace alidade
