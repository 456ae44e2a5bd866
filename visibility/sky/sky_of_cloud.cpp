// SPDX-License-Identifier: MIT
#include "visibility/sky/sky_of_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "visibility/point_blocks.h"
#include "visibility/raster/map_targets.h"

namespace alidade::visibility {

namespace {

constexpr float k_nothing = std::numeric_limits<float>::quiet_NaN();

std::optional<glm::dvec3> outward(std::span<const glm::vec3> normals, std::uint64_t point_id) {
  if (normals.empty()) return {};
  const glm::dvec3 normal(normals[point_id]);
  const bool says_something = std::isfinite(normal.x) && std::isfinite(normal.y) && std::isfinite(normal.z) &&
                              normal != glm::dvec3(0.0);
  if (!says_something) return {};
  return normal;
}

/// Targets of a block, by the number of lines to each: few enough for a part of a
/// long run that takes seconds.
std::size_t targets_at_once(std::size_t lines) {
  constexpr std::size_t k_most_lines = 1 << 24, k_least = 1 << 10, k_most = 1 << 14;
  return std::clamp(k_most_lines / std::max<std::size_t>(lines, 1), k_least, k_most);
}

/// Options of each target.
struct Question {
  std::size_t lines = 0;    ///< of sight
  std::size_t numbers = 1;  ///< answered
  SkyReceiver receiver = SkyReceiver::surface;
};

/// Numbers of the targets of a part, row after row with one number per target.
using Numbers = std::vector<float>;

/// Normal of the ground across a cell of a map.
glm::dvec3 ground_normal(const Ground& ground, const glm::dvec3& foot, double cell_size) {
  const auto slope = [&](const glm::dvec2& aside) {
    const glm::dvec2 middle(foot);
    const double here = ground.at(middle).value_or(foot.z);
    return (ground.at(middle + aside).value_or(here) - ground.at(middle - aside).value_or(here)) / cell_size;
  };
  return glm::normalize(glm::dvec3(-slope({0.5 * cell_size, 0.0}), -slope({0.0, 0.5 * cell_size}), 1.0));
}

/// Computes the numbers of all points, a block at a time: calls answer(targets, point ids), which returns
/// them, and take(point id, row, number) with each.
template <class Answer, class Take>
void for_each_point_target(const Occluders& occluders, std::span<const glm::vec3> normals,
                           const Question& question, const LongWork& work, Answer&& answer,
                           const Take& take) {
  const TreeView& tree = occluders.octree().view();
  check_that(normals.empty() || normals.size() == tree.point_count, "wrong number of normals",
             std::to_string(tree.point_count), std::to_string(normals.size()));
  const std::vector<std::vector<Leaf>> blocks = leaf_blocks(tree, targets_at_once(question.lines));
  std::uint64_t done = 0;
  report(work.progress, done, tree.point_count);
  run_parts(
      work.parts, blocks.size(),
      [&](std::uint64_t part, PartWriter& writer) {
        const std::vector<PlacedPoint> points = placed_points(tree, blocks[part]);
        std::vector<SkyTarget> targets(points.size());
        in_parallel(points.size(), 64, [&](std::size_t i) {
          targets[i] = target_on_point(occluders, points[i].point_id, points[i].position,
                                       outward(normals, points[i].point_id));
        });
        std::vector<std::uint64_t> point_ids;
        for (const PlacedPoint& point : points) point_ids.push_back(point.point_id);
        writer.put_all(answer(std::span<SkyTarget>(targets), std::span<const std::uint64_t>(point_ids)));
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::vector<PlacedPoint> points = placed_points(tree, blocks[part]);
        Numbers numbers(points.size());
        for (std::size_t row = 0; row < question.numbers; ++row) {
          reader.take_all(numbers);
          for (std::size_t i = 0; i < points.size(); ++i) take(points[i].point_id, row, numbers[i]);
        }
        report(work.progress, done += points.size(), tree.point_count);
      });
}

/// As for_each_point_target() for the cells of a map, by their number in it; k_nothing
/// for those without ground.
template <class Answer, class Take>
void for_each_ground_target(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
                            double height, const Question& question, const LongWork& work, Answer&& answer,
                            const Take& take) {
  check_that(height >= 0.0 && std::isfinite(height), "height above the ground out of range", "at least 0",
             std::to_string(height));
  const MapTargets map(occluders, ground, grid, 1, targets_at_once(question.lines));
  std::uint64_t done = 0;
  report(work.progress, done, grid.size());
  run_parts(
      work.parts, map.block_count(),
      [&](std::uint64_t part, PartWriter& writer) {
        const MapBlock block = map.block(part);
        std::vector<SkyTarget> targets;
        for (const MapTarget& target : block.targets)
          targets.push_back(target_in_open(raised(target.foot, height)));
        if (question.receiver == SkyReceiver::surface) {
          in_parallel(targets.size(), 64, [&](std::size_t i) {
            targets[i].normal = ground_normal(ground, targets[i].front.position, grid.cell_size);
            targets[i].is_front_open = true;
          });
        }
        const Numbers answers = answer(std::span<SkyTarget>(targets), std::span<const std::uint64_t>());
        Numbers numbers(block.cells.size());
        for (std::size_t row = 0; row < question.numbers; ++row) {
          std::ranges::fill(numbers, k_nothing);
          for (std::size_t i = 0; i < targets.size(); ++i)
            numbers[block.targets[i].cell] = answers[row * targets.size() + i];
          writer.put_all(numbers);
        }
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::vector<std::size_t> cells = map.cells(part);
        Numbers numbers(cells.size());
        for (std::size_t row = 0; row < question.numbers; ++row) {
          reader.take_all(numbers);
          for (std::size_t i = 0; i < cells.size(); ++i) take(cells[i], row, numbers[i]);
        }
        report(work.progress, done += cells.size(), grid.size());
      });
}

/// An `answer` that returns the sky-view factor of each target.
auto sky_answer(const Occluders& occluders, const SkyViewOptions& options) {
  return [&](std::span<SkyTarget> targets, std::span<const std::uint64_t>) {
    Numbers of_block(targets.size());
    sky_views(occluders, targets, options, of_block);
    return of_block;
  };
}

/// An `answer` that returns the numbers of a measure, row by row; finds the open sides with so many
/// directions first.
auto sun_answer(const Occluders& occluders, SunMeasure& measure, int side_directions) {
  return [&occluders, &measure, side_directions](std::span<SkyTarget> targets,
                                                 std::span<const std::uint64_t> point_ids) {
    if (side_directions > 0) find_open_sides(occluders, side_directions, targets);
    const std::size_t rows = measure.periods() * measure.numbers();
    Numbers of_block(targets.size() * rows), numbers;
    measure.answer(targets, point_ids, of_block);
    numbers.reserve(of_block.size());
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t i = 0; i < targets.size(); ++i) numbers.push_back(of_block[i * rows + row]);
    return numbers;
  };
}

Question sun_question(const SunMeasure& measure, int side_directions) {
  return {measure.lines() + static_cast<std::size_t>(side_directions), measure.periods() * measure.numbers(),
          measure.receiver()};
}

}  // namespace

std::vector<float> point_sky_views(const Occluders& occluders, std::span<const glm::vec3> normals,
                                   const SkyViewOptions& options, const LongWork& work) {
  std::vector<float> views(occluders.octree().size());
  for_each_point_target(occluders, normals, {static_cast<std::size_t>(options.directions), 1}, work,
                        sky_answer(occluders, options),
                        [&](std::uint64_t point_id, std::size_t, float number) { views[point_id] = number; });
  return views;
}

HugeVector<float> point_sun(const Occluders& occluders, std::span<const glm::vec3> normals,
                            SunMeasure& measure, const LongWork& work) {
  constexpr int k_side_directions = 64;
  const Question question = sun_question(measure, k_side_directions);
  HugeVector<float> answers(occluders.octree().size() * question.numbers);
  for_each_point_target(occluders, normals, question, work, sun_answer(occluders, measure, k_side_directions),
                        [&](std::uint64_t point_id, std::size_t row, float number) {
                          answers[point_id * question.numbers + row] = number;
                        });
  return answers;
}

geo::Raster<float> ground_sky_views(const Occluders& occluders, const Ground& ground,
                                    const geo::RasterGrid& grid, double height, const SkyViewOptions& options,
                                    const LongWork& work) {
  geo::check_map_memory(grid, 1);
  geo::Raster<float> views(grid, k_nothing);
  for_each_ground_target(occluders, ground, grid, height,
                         {static_cast<std::size_t>(options.directions), 1, options.receiver}, work,
                         sky_answer(occluders, options),
                         [&](std::size_t cell, std::size_t, float number) { views.values[cell] = number; });
  return views;
}

HugeVector<float> ground_sun(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
                             double height, SunMeasure& measure, const LongWork& work) {
  const Question question = sun_question(measure, 0);
  geo::check_map_memory(grid, static_cast<int>(question.numbers + measure.periods()));
  HugeVector<float> answers(grid.size() * question.numbers, k_nothing);
  for_each_ground_target(occluders, ground, grid, height, question, work, sun_answer(occluders, measure, 0),
                         [&](std::size_t cell, std::size_t row, float number) {
                           answers[cell * question.numbers + row] = number;
                         });
  return answers;
}

}  // namespace alidade::visibility
