// SPDX-License-Identifier: MIT
#include "visibility/raster/viewshed.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/checkpoint.h"
#include "base/error.h"
#include "base/huge_memory.h"
#include "octree/spacing.h"
#include "visibility/crossing.h"
#include "visibility/raster/map_targets.h"

namespace alidade::visibility {

namespace {

constexpr double k_finest = 0.01;  // of a height, in the unit of the cloud
/// Bent lines consist of many chords, which are all in memory.
constexpr std::size_t k_chords_at_once = 1 << 16;

/// Finds the lowest height above positions on the ground that is seen, as viewshed.h defines it.
class LowestSeen {
 public:
  /// The references must outlive this. Memory: 4 B per point, unless all have one radius; with an octree in
  /// scratch files on the disk. Errors: not enough memory.
  LowestSeen(const Occluders& occluders, const ViewshedOptions& options)
      : occluders_(occluders),
        options_(options),
        batch_(occluders, options.curve),
        is_terrain_alone_(occluders.octree().size() == 0 && occluders.options().mesh == nullptr) {
    const Octree& octree = occluders.octree();
    if (occluders.options().radius) return;
    if (!octree.scratch()) check_memory(sizeof(float) * octree.size(), "the spacings of the points");
    spacings_ = spacings_in_order(octree);
  }

  /// Lowers `heights`, one per target, if this observer sees something lower. Those of targets that it does
  /// not look at remain as they are; the others become `highest` at most.
  void look(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights) {
    searches_.clear();
    seen_.clear();
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const std::optional<HeightRange> range =
          observer.heights_in_view(targets[i].foot.position, {options_.target_height, options_.highest});
      if (!range) continue;
      heights[i] = std::min(heights[i], options_.highest);
      if (range->low >= heights[i]) continue;
      // If the lowest height is seen, there is no interval to halve.
      searches_.push_back({i, range->low, range->low, range->high});
    }
    climb(observer, targets, heights);
    halve(observer, targets, heights);
  }

  std::uint64_t line_count() const { return line_count_; }

 private:
  struct Search {
    std::size_t target;
    double blocked;  ///< highest that is not seen
    double tried;    ///< to be tried next
    double highest;  ///< in the observer's view
  };

  /// By how much a line is raised at its blocker. Openings of meshes are searched in
  /// steps as wide as the cloud's.
  double step_past(const Blocker& blocker) const {
    if (blocker.is_mesh()) return occluders_.typical_radius();
    const std::uint64_t point_id = blocker.point_id;
    const double radius = candidate_radius(occluders_, spacings_.empty() ? 0.0 : spacings_[point_id]);
    return occluders_.surface(point_id).exists ? radius : sphere_of(occluders_, radius);
  }

  /// Fills the batch with lines to the heights that the searches from `begin` on try next; returns
  /// the end of these searches.
  std::size_t aim(const MapObserver& observer, std::span<const MapTarget> targets, std::size_t begin) {
    batch_.clear();
    std::size_t end = begin;
    for (; end < searches_.size() && batch_.chord_count() < k_chords_at_once; ++end) {
      const Search& search = searches_[end];
      batch_.add(observer.eye(), raised(targets[search.target].foot, search.tried));
    }
    line_count_ += batch_.size();
    return end;
  }

  void climb(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights) {
    while (!searches_.empty()) {
      std::size_t left = 0;
      for (std::size_t begin = 0, end = 0; begin < searches_.size(); begin = end) {
        end = aim(observer, targets, begin);
        const std::span<const std::optional<Blocker>> blockers = batch_.first_blockers();
        for (std::size_t i = begin; i < end; ++i) {
          Search search = searches_[i];
          const std::optional<Blocker>& blocker = blockers[i - begin];
          if (!blocker) {
            seen_.push_back(search);
            continue;
          }
          const glm::dvec3 position = raised(targets[search.target].foot, search.tried).position;
          const double magnified =
              glm::length(position - observer.eye().position) / std::max(blocker->distance, k_finest);
          search.blocked = search.tried;
          const double lowest = heights[search.target];
          if (is_terrain_alone_) {
            search.tried = std::min(search.highest, lowest);
            if (search.tried > search.blocked) searches_[left++] = search;
            continue;
          }
          search.tried += std::max(k_finest, step_past(*blocker) * std::max(magnified, 1.0));
          search.tried = std::min(search.tried, search.highest);
          // Heights above the lowest one that another observer sees do not matter.
          if (search.tried > search.blocked && search.tried < lowest) searches_[left++] = search;
        }
      }
      searches_.resize(left);
    }
  }

  void halve(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights) {
    while (!seen_.empty()) {
      searches_.clear();
      std::size_t left = 0;
      for (const Search& search : seen_) {
        heights[search.target] = std::min(heights[search.target], search.tried);
        if (search.tried - search.blocked <= k_finest) continue;
        seen_[left++] = search;
        searches_.push_back(
            {search.target, search.blocked, 0.5 * (search.blocked + search.tried), search.tried});
      }
      seen_.resize(left);
      for (std::size_t begin = 0, end = 0; begin < left; begin = end) {
        end = aim(observer, targets, begin);
        const std::span<const std::uint8_t> blocked = batch_.blocked();
        for (std::size_t i = begin; i < end; ++i) {
          if (blocked[i - begin])
            seen_[i].blocked = searches_[i].tried;
          else
            seen_[i].tried = searches_[i].tried;
        }
      }
    }
  }

  const Occluders& occluders_;
  ViewshedOptions options_;
  HugeVector<float> spacings_;  ///< by point id; empty if all points have one radius
  SightBatch batch_;
  bool is_terrain_alone_;  ///< then everything above a height that is seen is seen, too
  std::vector<Search> searches_, seen_;
  std::uint64_t line_count_ = 0;
};

/// Enough for all threads, little enough to stay in a cache.
constexpr std::size_t k_batch = 1 << 16;

void check(std::span<const Observer> observers, const ViewshedOptions& options) {
  if (observers.empty()) throw Error({.problem = "a viewshed requires an observer"});
  check_that(options.positions_across >= 1 && options.positions_across <= k_most_positions_across,
             "invalid number of positions across a cell", fmt::format("1 to {}", k_most_positions_across),
             fmt::format("{}", options.positions_across));
  check_that(options.target_height >= 0.0 && std::isfinite(options.target_height), "invalid target height",
             "at least 0", fmt::format("{}", options.target_height));
  check_that(options.mode != ViewshedMode::height ||
                 (options.highest > options.target_height && std::isfinite(options.highest)),
             "invalid maximum height", "more than the target height", fmt::format("{}", options.highest));
  const bool is_of_objects = !options.pieces.empty();
  check_that(!is_of_objects || options.pieces.size() == observers.size(), "invalid samples of objects",
             fmt::format("{} pieces", observers.size()), fmt::format("{}", options.pieces.size()));
  const bool needs_objects = options.mode == ViewshedMode::size || options.mode == ViewshedMode::angle;
  check_that(options.mode == ViewshedMode::height ? !is_of_objects : is_of_objects || !needs_objects,
             "invalid map", needs_objects ? "objects" : "observers");
  const auto has_area = [](const ObjectPiece& piece) { return piece.width > 0.0; };
  check_that(options.mode != ViewshedMode::angle || std::ranges::all_of(options.pieces, has_area),
             "no solid angle of objects without a width", "a width");
}

/// Reports the progress of the map, in pairs of observer and position.
struct PairCounter {
  const Progress& progress;
  std::uint64_t total, done = 0;

  /// Within a block; positions without ground do not count.
  void add(std::uint64_t pairs) { report(progress, done += pairs, total); }
  /// At the end of a block.
  void set(std::uint64_t pairs) { report(progress, done = pairs, total); }
};

/// Largest number of positions of a block: enough for all threads, few enough for little memory and for a
/// part of a long run that takes seconds.
std::size_t most_positions(std::size_t observers, ViewshedMode mode) {
  constexpr std::size_t k_most_lines = 1 << 24, k_lines_per_height = 16, k_least = 1 << 10, k_most = 1 << 18;
  const std::size_t lines = mode == ViewshedMode::height ? k_lines_per_height : 1;
  return std::clamp(k_most_lines / lines / observers, k_least, k_most);
}

/// Sums what is seen from or of the cells of a block, observer by observer.
class SeenCounter {
 public:
  SeenCounter(const Occluders& occluders, const ViewshedOptions& options)
      : options_(options), batch_(occluders, options.curve) {}

  std::vector<float> look(std::span<const MapObserver> observers, const MapBlock& block, PairCounter& pairs) {
    sums_.assign(block.cells.size(), {});
    for (std::size_t i = 0; i < observers.size(); ++i) {
      for (const MapTarget& target : block.targets) aim(observers[i], i, target);
      pairs.add(block.targets.size());
    }
    count();
    std::vector<float> values(block.cells.size(), k_no_ground);
    for (const MapTarget& target : block.targets) values[target.cell] = value_of(sums_[target.cell]);
    return values;
  }

  std::uint64_t line_count() const { return line_count_; }

 private:
  /// The sums of one cell.
  struct Sums {
    bool is_looked_at = false;
    std::size_t last_seen = 0;     ///< number of the object that was seen last, from 1
    double all = 0.0, seen = 0.0;  ///< weights of lines
  };
  /// A line of the batch.
  struct Look {
    std::size_t cell, object;
    double weight;
  };

  void aim(const MapObserver& observer, std::size_t number, const MapTarget& target) {
    const ObjectPiece* piece = options_.pieces.empty() ? nullptr : &options_.pieces[number];
    const std::size_t object = piece != nullptr ? piece->object : number;
    const Sums& sums = sums_[target.cell];
    // Cells that are already seen need no further line.
    if (options_.mode == ViewshedMode::visible && sums.last_seen > 0) return;
    if (options_.mode == ViewshedMode::count && sums.last_seen == object + 1) return;
    const SightEnd end = raised(target.foot, options_.target_height);
    if (!observer.looks_at(end.position)) return;
    if (piece != nullptr && !faces(*piece, observer.eye().position, end.position)) return;
    batch_.add(observer.eye(), end);
    looks_.push_back({target.cell, object, weight_of(piece, observer.eye().position, end.position)});
    if (batch_.chord_count() >= k_batch || looks_.size() >= k_batch) count();
  }

  double weight_of(const ObjectPiece* piece, const glm::dvec3& middle, const glm::dvec3& eye) const {
    if (piece == nullptr || options_.mode == ViewshedMode::visible || options_.mode == ViewshedMode::count)
      return 1.0;
    return options_.mode == ViewshedMode::angle ? solid_angle(*piece, middle, eye) : piece->size();
  }

  void count() {
    const std::span<const std::uint8_t> blocked = batch_.blocked();
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      const Look& look = looks_[i];
      Sums& sums = sums_[look.cell];
      sums.is_looked_at = true;
      sums.all += look.weight;
      if (blocked[i]) continue;
      if (options_.mode != ViewshedMode::count || sums.last_seen != look.object + 1) sums.seen += look.weight;
      sums.last_seen = look.object + 1;
    }
    line_count_ += looks_.size();
    batch_.clear();
    looks_.clear();
  }

  float value_of(const Sums& sums) const {
    if (!sums.is_looked_at) return k_out_of_range;
    const auto seen = static_cast<float>(sums.seen);
    if (options_.mode == ViewshedMode::visible) return seen > 0.0f ? 1.0f : 0.0f;
    return options_.mode == ViewshedMode::fraction ? seen / static_cast<float>(sums.all) : seen;
  }

  const ViewshedOptions& options_;
  std::vector<Sums> sums_;  ///< of each cell
  SightBatch batch_;
  std::vector<Look> looks_;
  std::uint64_t line_count_ = 0;
};

/// Finds the lowest heights over the cells of a block.
std::vector<float> lowest_heights(LowestSeen& lowest, std::span<const MapObserver> observers,
                                  const MapBlock& block, PairCounter& pairs) {
  constexpr std::size_t k_targets_at_once = 1 << 13;
  std::vector<double> heights(block.targets.size(), std::numeric_limits<double>::infinity());
  const std::span<const MapTarget> targets(block.targets);
  for (std::size_t begin = 0; begin < targets.size(); begin += k_targets_at_once) {
    const std::size_t count = std::min(k_targets_at_once, targets.size() - begin);
    for (const MapObserver& observer : observers) {
      lowest.look(observer, targets.subspan(begin, count), std::span(heights).subspan(begin, count));
      pairs.add(count);
    }
  }
  std::vector<float> values(block.cells.size(), k_no_ground);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    values[targets[i].cell] = std::isfinite(heights[i]) ? static_cast<float>(heights[i]) : k_out_of_range;
  }
  return values;
}

}  // namespace

Viewshed viewshed(const Occluders& occluders, const Ground& ground, std::span<const Observer> observers,
                  const geo::RasterGrid& grid, const ViewshedOptions& options) {
  check(observers, options);
  geo::check_map_memory(grid, 1);
  Viewshed result{geo::Raster<float>(grid, k_no_ground)};
  const int positions_across = options.mode == ViewshedMode::fraction ? options.positions_across : 1;
  std::vector<MapObserver> eyes;
  for (const Observer& observer : observers) eyes.emplace_back(occluders, observer);
  const MapTargets targets(occluders, ground, grid, positions_across,
                           most_positions(eyes.size(), options.mode));
  const std::uint64_t pairs_per_cell =
      eyes.size() * static_cast<std::uint64_t>(positions_across * positions_across);
  PairCounter pairs{options.progress, pairs_per_cell * grid.size()};
  SeenCounter counter(occluders, options);
  std::optional<LowestSeen> lowest;
  if (options.mode == ViewshedMode::height) lowest.emplace(occluders, options);
  std::uint64_t cells_done = 0;
  run_parts(
      options.parts, targets.block_count(),
      [&](std::uint64_t part, PartWriter& writer) {
        const MapBlock block = targets.block(part);
        writer.put_all(lowest ? lowest_heights(*lowest, eyes, block, pairs)
                              : counter.look(eyes, block, pairs));
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::vector<std::size_t> cells = targets.cells(part);
        std::vector<float> values(cells.size());
        reader.take_all(values);
        for (std::size_t i = 0; i < cells.size(); ++i) result.values.values[cells[i]] = values[i];
        pairs.set(pairs_per_cell * (cells_done += cells.size()));
      });
  result.line_count = lowest ? lowest->line_count() : counter.line_count();
  return result;
}

}  // namespace alidade::visibility
