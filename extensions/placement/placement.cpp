// SPDX-License-Identifier: MIT
#include "extensions/placement/placement.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <queue>
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

constexpr std::size_t k_targets_per_block = 1 << 18;

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

void check(const Coverage& coverage, std::size_t count, std::span<const double> weights) {
  check_that(count > 0, "invalid number of positions", "at least 1");
  check_that(weights.empty() || weights.size() == coverage.targets(),
             "the number of weights differs from the number of targets", std::to_string(coverage.targets()),
             std::to_string(weights.size()));
  const auto wrong =
      std::ranges::find_if(weights, [](double weight) { return !(weight >= 0.0 && std::isfinite(weight)); });
  if (wrong != weights.end())
    check_that(false, "invalid target weight", "at least 0", std::to_string(*wrong));
}

/// The targets seen by the chosen candidates, and the gain of a further one. Sums run over the targets in
/// their order: rounding never makes a sum of fewer terms larger, so computed gains do not grow, either.
class Covered {
 public:
  Covered(const Coverage& coverage, std::span<const double> weights)
      : coverage_(coverage), weights_(weights), words_((coverage.targets() + 63) / 64) {}

  double gain(std::size_t candidate) const {
    const std::span<const std::uint64_t> row = coverage_.row(candidate);
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::uint64_t added = row[i] & ~words_[i];
      if (weights_.empty()) {
        count += static_cast<std::size_t>(std::popcount(added));
        continue;
      }
      for (; added != 0; added &= added - 1)
        sum += weights_[64 * i + static_cast<std::size_t>(std::countr_zero(added))];
    }
    return weights_.empty() ? static_cast<double>(count) : sum;
  }

  void add(std::size_t candidate) {
    const std::span<const std::uint64_t> row = coverage_.row(candidate);
    for (std::size_t i = 0; i < row.size(); ++i) words_[i] |= row[i];
  }

 private:
  const Coverage& coverage_;
  std::span<const double> weights_;
  std::vector<std::uint64_t> words_;
};

/// A candidate with its gain at the time when so many were chosen.
struct Offer {
  double gain;
  std::size_t candidate;
  std::size_t chosen;
  /// Whether `other` is to be examined first.
  bool operator<(const Offer& other) const {
    return gain < other.gain || (gain == other.gain && candidate > other.candidate);
  }
};

double sum_of_largest(std::vector<double> gains, std::size_t count) {
  count = std::min(count, gains.size());
  std::ranges::sort(gains, std::greater());
  return std::accumulate(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(count), 0.0);
}

std::vector<double> all_gains(const Coverage& coverage, const Covered& covered) {
  std::vector<double> gains(coverage.candidates());
  for (std::size_t i = 0; i < gains.size(); ++i) gains[i] = covered.gain(i);
  return gains;
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
  static_assert(k_targets_per_block % 64 == 0);
  Coverage coverage(candidates.size(), targets.size());
  const std::size_t blocks = (targets.size() + k_targets_per_block - 1) / k_targets_per_block;
  const auto block = [&](std::uint64_t part) {
    const std::size_t first = part % blocks * k_targets_per_block;
    return targets.subspan(first, std::min(k_targets_per_block, targets.size() - first));
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
        coverage.set_words(part / blocks, part % blocks * (k_targets_per_block / 64), words);
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

Placement choose_places(const Coverage& coverage, std::size_t count, std::span<const double> weights) {
  check(coverage, count, weights);
  Placement placement;
  placement.total = weights.empty() ? static_cast<double>(coverage.targets())
                                    : std::accumulate(weights.begin(), weights.end(), 0.0);
  Covered covered(coverage, weights);
  const std::vector<double> alone = all_gains(coverage, covered);
  std::priority_queue<Offer> offers;
  for (std::size_t i = 0; i < alone.size(); ++i) offers.push({alone[i], i, 0});
  double sum = 0.0;
  // No choice covers more than all targets, or than what is covered at any time plus the largest gains of as
  // many candidates as requested, as if these saw no target twice.
  double bound = std::min(placement.total, sum_of_largest(alone, count));
  std::size_t next_bound = 1;
  while (placement.positions.size() < count && !offers.empty()) {
    const Offer offer = offers.top();
    offers.pop();
    if (offer.chosen < placement.positions.size()) {
      offers.push({covered.gain(offer.candidate), offer.candidate, placement.positions.size()});
      continue;
    }
    if (offer.gain <= 0.0) break;
    covered.add(offer.candidate);
    sum += offer.gain;
    placement.positions.push_back({offer.candidate, offer.gain, sum});
    // Not after each choice, since the gains of all candidates take a pass over the bits.
    if (placement.positions.size() != next_bound) continue;
    bound = std::min(bound, sum + sum_of_largest(all_gains(coverage, covered), count));
    next_bound *= 2;
  }
  bound = std::min(bound, sum + sum_of_largest(all_gains(coverage, covered), count));
  placement.best_possible = std::max(bound, sum);
  return placement;
}

std::vector<Row> placement_rows(const Placement& placement, std::span<const Observer> candidates) {
  std::vector<Row> rows;
  for (const ChosenPosition& chosen : placement.positions) {
    const Observer& observer = candidates[chosen.candidate];
    Row row;
    row["place"] = rows.size() + 1;
    row["candidate"] = chosen.candidate;
    row["name"] = observer.name;
    row["x"] = observer.position.x;
    row["y"] = observer.position.y;
    row["z"] = observer.position.z;
    row["gain"] = chosen.gain;
    row["covered"] = chosen.covered;
    row["share"] = chosen.covered / placement.total;
    rows.push_back(row);
  }
  return rows;
}

bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite) {
  PositionTable table{.list = "places", .rows = placement_rows(placement, candidates), .positions = {}};
  for (const ChosenPosition& chosen : placement.positions)
    table.positions.push_back(candidates[chosen.candidate].position);
  const Row totals{{"total", placement.total}, {"best_possible", placement.best_possible}};
  return write_positions(table, totals, form, head, to_lon_lat, file, overwrite);
}

}  // namespace alidade::visibility
