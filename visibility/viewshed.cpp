// SPDX-License-Identifier: MIT
#include "visibility/viewshed.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "octree/error.h"
#include "visibility/lowest_seen.h"
#include "visibility/map_observer.h"
#include "visibility/map_targets.h"

namespace alidade {
namespace {

/// Enough for all threads, little enough to stay in a cache.
constexpr std::size_t k_batch = 1 << 16;

void check(std::span<const Observer> observers, const ViewshedOptions& options) {
  constexpr int k_most_across = 100;
  if (observers.empty()) throw Error({.problem = "a viewshed needs an observer"});
  if (options.places_across < 1 || options.places_across > k_most_across) {
    throw Error({.problem = "bad number of places across a cell",
                 .expected = "1 to 100",
                 .found = fmt::format("{}", options.places_across)});
  }
  if (!(options.target_height >= 0.0) || !std::isfinite(options.target_height)) {
    throw Error({.problem = "bad height of what is looked at",
                 .expected = "0 or more",
                 .found = fmt::format("{}", options.target_height)});
  }
  if (options.mode == ViewshedMode::height &&
      (!(options.highest > options.target_height) || !std::isfinite(options.highest))) {
    throw Error({.problem = "bad highest height",
                 .expected = "more than that of what is looked at",
                 .found = fmt::format("{}", options.highest)});
  }
}

/// Counts what is seen of every cell.
class SeenCounter {
 public:
  SeenCounter(const Occluders& occluders, const ViewshedOptions& options, Raster<float>& values)
      : options_(options),
        values_(values),
        looks_(values.values.size(), 0),
        batch_(occluders, options.curve) {}

  void look(const MapObserver& observer, std::span<const MapTarget> targets) {
    for (const MapTarget& target : targets) {
      // Who is seen already need not be seen again.
      if (options_.mode == ViewshedMode::visible && values_.values[target.cell] > 0.0f) continue;
      const SightEnd end = raised(target.foot, options_.target_height);
      if (!observer.looks_at(end.position)) continue;
      batch_.add(observer.eye, end);
      cells_.push_back(target.cell);
      if (batch_.chord_count() >= k_batch) count();
    }
  }

  void count() {
    const std::span<const std::uint8_t> blocked = batch_.blocked();
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      float& value = values_.values[cells_[i]];
      if (value == k_out_of_range) value = 0.0f;
      value += blocked[i] ? 0.0f : 1.0f;
      ++looks_[cells_[i]];
    }
    line_count_ += cells_.size();
    batch_.clear();
    cells_.clear();
  }

  /// Makes of the counts what was asked for.
  void finish() {
    count();
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      float& value = values_.values[i];
      if (!(value > 0.0f)) continue;
      if (options_.mode == ViewshedMode::visible) value = 1.0f;
      if (options_.mode == ViewshedMode::fraction) value /= static_cast<float>(looks_[i]);
    }
  }

  std::uint64_t line_count() const { return line_count_; }

 private:
  const ViewshedOptions& options_;
  Raster<float>& values_;
  std::vector<std::uint32_t> looks_;  ///< at each cell
  SightBatch batch_;
  std::vector<std::size_t> cells_;  ///< of the batch's lines
  std::uint64_t line_count_ = 0;
};

/// Looks at one block of the map with every observer.
using LookAtBlock = std::function<void(std::span<const MapTarget>)>;

void for_each_block(const MapTargets& targets, Raster<float>& values, const LookAtBlock& look) {
  std::vector<MapTarget> block;
  for (std::size_t number = 0; number < targets.block_count(); ++number) {
    targets.block(number, block);
    for (const MapTarget& target : block) values.values[target.cell] = k_out_of_range;
    look(block);
  }
}

}  // namespace

Viewshed viewshed(const Occluders& occluders, const Ground& ground, std::span<const Observer> observers,
                  const RasterGrid& grid, const ViewshedOptions& options) {
  constexpr std::uint64_t k_bytes_per_cell = 12;  // with what writing it takes
  check(observers, options);
  check_memory(k_bytes_per_cell * grid.size(), "the map");
  const bool by_height = options.mode == ViewshedMode::height;
  const int places_across = options.mode == ViewshedMode::fraction ? options.places_across : 1;
  Viewshed result{Raster<float>(grid, k_no_ground)};
  const std::vector<MapObserver> eyes = map_observers(occluders, observers);
  const MapTargets targets(occluders, ground, grid, places_across);
  const std::uint64_t pairs =
      grid.size() * eyes.size() * static_cast<std::uint64_t>(places_across * places_across);
  std::uint64_t done = 0;
  const auto report_block = [&](std::size_t count) { report(options.progress, done += count, pairs); };

  if (by_height) {
    LowestSeen lowest(occluders, options);
    std::vector<double> heights;
    for_each_block(targets, result.values, [&](std::span<const MapTarget> block) {
      heights.assign(block.size(), std::numeric_limits<double>::infinity());
      for (const MapObserver& eye : eyes) {
        lowest.look(eye, block, heights);
        report_block(block.size());
      }
      for (std::size_t i = 0; i < block.size(); ++i) {
        if (std::isfinite(heights[i])) result.values.values[block[i].cell] = static_cast<float>(heights[i]);
      }
    });
    result.line_count = lowest.line_count();
  } else {
    SeenCounter counter(occluders, options, result.values);
    for_each_block(targets, result.values, [&](std::span<const MapTarget> block) {
      for (const MapObserver& eye : eyes) {
        counter.look(eye, block);
        report_block(block.size());
      }
    });
    counter.finish();
    result.line_count = counter.line_count();
  }
  report(options.progress, pairs, pairs);
  return result;
}

}  // namespace alidade
