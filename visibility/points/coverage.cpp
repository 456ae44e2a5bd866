// SPDX-License-Identifier: MIT
#include "visibility/points/coverage.h"

#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "cloud/lattice.h"
#include "octree/distance.h"
#include "octree/tree_walk.h"

namespace alidade::visibility {
namespace {

constexpr std::size_t k_lines_at_once = 1 << 18;

/// The targets within reach and view, and the lines to them.
struct Views {
  std::vector<std::size_t> targets;
  std::vector<SightLine> lines;
};

/// A block of the targets. `ends`: where the lines to them end; empty if they end on the points themselves,
/// since those ends depend on the observer.
struct TargetBlock {
  std::span<const PlacementTarget> targets;
  std::span<const SightEnd> ends;
};

std::vector<SightEnd> raised_ends(const Occluders& occluders, std::span<const PlacementTarget> targets,
                                  double height) {
  std::vector<SightEnd> ends(targets.size());
  in_parallel(targets.size(), 64, [&](std::size_t i) {
    ends[i] = end_near_surface(occluders, targets[i].position + glm::dvec3(0.0, 0.0, height));
  });
  return ends;
}

Views views_of(const Occluders& occluders, const Observer& observer, const TargetBlock& block) {
  const std::span<const PlacementTarget> targets = block.targets;
  const std::span<const SightEnd> ends = block.ends;
  const FieldOfView field(observer);
  const SightEnd eye = end_near_surface(occluders, observer.position);
  Views views;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3& position = ends.empty() ? targets[i].position : ends[i].position;
    if (field.reaches(position - observer.position)) views.targets.push_back(i);
  }
  views.lines.resize(views.targets.size());
  in_parallel(views.lines.size(), 64, [&](std::size_t i) {
    const std::size_t number = views.targets[i];
    const PlacementTarget& target = targets[number];
    views.lines[i] = sight_line(
        eye, ends.empty() ? end_on_point(occluders, target.point_id, target.position, observer.position)
                          : ends[number]);
  });
  return views;
}

/// A bit for each target, in the layout of Coverage::row().
std::vector<std::uint64_t> seen_by(const Occluders& occluders, const Observer& observer,
                                   const TargetBlock& block) {
  const Views views = views_of(occluders, observer, block);
  std::vector<std::uint8_t> hidden(views.lines.size());
  blocked(occluders, views.lines, hidden);
  std::vector<std::uint64_t> words((block.targets.size() + 63) / 64);
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const std::size_t target = views.targets[i];
    if (hidden[i] == 0) words[target / 64] |= std::uint64_t{1} << (target % 64);
  }
  return words;
}

constexpr int k_cell_bits = 21;
/// Memory while points are chosen: a node of the map with its share of the table, and a copy.
constexpr std::uint64_t k_bytes_per_cell = 140;

/// The point that represents a cell so far.
struct Best {
  PlacementTarget target;
  double distance = 0.0;    ///< to the cell's middle
  std::uint64_t index = 0;  ///< storage index
};

void check_spacing(const Octree& octree, double spacing) {
  const glm::dvec3 size = octree.bounds().size();
  const double longest = std::max({size.x, size.y, size.z});
  check_that(spacing > 0.0 && std::isfinite(spacing), "invalid target spacing", "a positive length",
             std::to_string(spacing));
  check_that(!(longest / spacing >= static_cast<double>((1 << k_cell_bits) - 1)),
             "target spacing too small for the extent of the cloud",
             "at least " + std::to_string(longest / ((1 << k_cell_bits) - 2)), std::to_string(spacing));
}

}  // namespace

void check_coverage(std::size_t candidates, std::size_t targets) {
  const std::uint64_t row_bytes = std::uint64_t{8} * ((targets + 63) / 64);
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(std::uint64_t{candidates}, row_bytes, &bytes) ||
      __builtin_add_overflow(bytes, std::uint64_t{sizeof(SightEnd)} * targets, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "the visibility of each target from each candidate");
}

Coverage::Coverage(std::size_t candidates, std::size_t targets)
    : candidates_(candidates), targets_(targets), row_words_((targets + 63) / 64) {
  check_coverage(candidates, targets);
  words_.resize(candidates_ * row_words_);
}

Coverage see_targets(const Occluders& occluders, std::span<const Observer> candidates,
                     std::span<const PlacementTarget> targets, double height, const Progress& progress,
                     PartCheckpoint* parts) {
  check_that(height >= 0.0 && std::isfinite(height), "invalid target height", "at least 0",
             std::to_string(height));
  static_assert(k_lines_at_once % 64 == 0);
  Coverage coverage(candidates.size(), targets.size());
  const std::size_t blocks = (targets.size() + k_lines_at_once - 1) / k_lines_at_once;
  const auto block = [&](std::uint64_t part) {
    const std::size_t first = part % blocks * k_lines_at_once;
    return targets.subspan(first, std::min(k_lines_at_once, targets.size() - first));
  };
  // Of each block, filled when it is first examined.
  std::vector<std::vector<SightEnd>> ends(blocks);
  std::uint64_t done = 0;
  run_parts(
      parts, std::uint64_t{candidates.size()} * blocks,
      [&](std::uint64_t part, PartWriter& writer) {
        std::vector<SightEnd>& block_ends = ends[part % blocks];
        if (height > 0.0 && block_ends.empty()) block_ends = raised_ends(occluders, block(part), height);
        const std::vector<std::uint64_t> words =
            seen_by(occluders, candidates[part / blocks], {block(part), block_ends});
        writer.put_all(words);
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::size_t count = block(part).size();
        std::vector<std::uint64_t> words((count + 63) / 64);
        reader.take_all(words);
        reader.require(count % 64 == 0 || words.back() >> (count % 64) == 0);
        coverage.set_words(part / blocks, part % blocks * (k_lines_at_once / 64), words);
        report(progress, done += count, std::uint64_t{candidates.size()} * targets.size());
      });
  return coverage;
}

std::vector<PlacementTarget> thin_points(const Octree& octree, double spacing,
                                         const std::function<bool(std::uint64_t point_id)>& counts,
                                         const Progress& progress) {
  check_spacing(octree, spacing);
  const TreeView& tree = octree.view();
  const glm::dvec3 corner = octree.bounds().min;
  std::unordered_map<std::uint64_t, Best> cells;
  // The memory is checked each time the number of cells has doubled.
  std::size_t next_check = 1 << 20;
  constexpr std::uint64_t k_points_per_report = 1 << 20;
  std::uint64_t done = 0;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const std::uint64_t id = point_id(tree, leaf.first + i);
      if (counts && !counts(id)) continue;
      const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, i));
      std::uint64_t key = 0;
      glm::dvec3 middle{0.0};
      for (int axis = 0; axis < 3; ++axis) {
        const double cell = std::floor((position[axis] - corner[axis]) / spacing);
        key = key << k_cell_bits | static_cast<std::uint64_t>(cell);
        middle[axis] = corner[axis] + (cell + 0.5) * spacing;
      }
      const Best here{{id, position}, distance(middle, position), leaf.first + i};
      const auto [found, is_new] = cells.try_emplace(key, here);
      Best& best = found->second;
      const bool is_nearer =
          here.distance < best.distance || (here.distance == best.distance && id < best.target.point_id);
      if (!is_new && is_nearer) best = here;
    }
    const std::uint64_t before = std::exchange(done, done + leaf.count);
    if (before / k_points_per_report != done / k_points_per_report) report(progress, done, tree.point_count);
    if (cells.size() < next_check) return;
    check_memory(k_bytes_per_cell * cells.size(), "targets at this spacing");
    next_check *= 2;
  });
  report(progress, done, tree.point_count);
  std::vector<Best> chosen;
  chosen.reserve(cells.size());
  for (const auto& [key, best] : cells) chosen.push_back(best);
  cells = {};
  std::ranges::sort(chosen, {}, &Best::index);
  std::vector<PlacementTarget> targets;
  targets.reserve(chosen.size());
  for (const Best& best : chosen) targets.push_back(best.target);
  return targets;
}

}  // namespace alidade::visibility
