// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "octree/octree.h"
#include "visibility/observers.h"
#include "visibility/row_text.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {

/// Checks the memory before a run. Errors: not enough memory for a Coverage and see_targets();
/// the message has the amount.
void check_coverage(std::size_t candidates, std::size_t targets);

/// Which candidates see which targets: a bit for each pair.
class Coverage {
 public:
  /// Without any bit set. Errors: those of check_coverage().
  Coverage(std::size_t candidates, std::size_t targets);

  std::size_t candidates() const { return candidates_; }
  std::size_t targets() const { return targets_; }
  bool sees(std::size_t candidate, std::size_t target) const {
    return (row(candidate)[target / 64] >> (target % 64) & 1) != 0;
  }
  void set(std::size_t candidate, std::size_t target) {
    words_[candidate * row_words_ + target / 64] |= std::uint64_t{1} << (target % 64);
  }
  /// Sets the words of row() from `first` on. Requires that no bit after the last target is set.
  void set_words(std::size_t candidate, std::size_t first, std::span<const std::uint64_t> words) {
    std::ranges::copy(words, words_.begin() + static_cast<std::ptrdiff_t>(candidate * row_words_ + first));
  }
  /// Target i is bit i % 64 of word i / 64; bits after the last target are 0.
  std::span<const std::uint64_t> row(std::size_t candidate) const {
    return std::span(words_).subspan(candidate * row_words_, row_words_);
  }

 private:
  std::size_t candidates_, targets_, row_words_;
  std::vector<std::uint64_t> words_;
};

/// A point to be seen.
struct PlacementTarget {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};  ///< of the point
};

/// Follows a sight line from every candidate to every target in its field of view and reach. With a `height`
/// of 0 lines end on the points (end_on_point()); else so many metres straight above them. Candidates that
/// are on a surface see over it (end_near_surface()). `progress` is in sight lines. The same on any number of
/// threads. Cost: candidates times targets, up to a microsecond each; fast if targets near each other follow
/// each other. Memory: a bit per pair, and 40 B per target. Finished blocks, with a bit per line, are kept in
/// `parts` unless it is null. Errors: those of Coverage; height negative or not finite.
Coverage see_targets(const Occluders& occluders, std::span<const Observer> candidates,
                     std::span<const PlacementTarget> targets, double height, const Progress& progress = {},
                     PartCheckpoint* parts = nullptr);

/// Some points that represent all: of the counted points of every cubic cell of a grid, the one nearest to
/// the cell's middle, of equally near ones the one with the lowest id. They are in the order of the octree,
/// which has neighbours together. `counts`: empty for all. `progress` is in points. Cost: about 100 ns per
/// point. Memory: 140 B per cell with points, 32 B afterwards. Errors: spacing not above 0 or not finite, or
/// finer than 2^-21 of the cloud's longest side; not enough memory.
std::vector<PlacementTarget> thin_points(const Octree& octree, double spacing,
                                         const std::function<bool(std::uint64_t point_id)>& counts = {},
                                         const Progress& progress = {});

// A choice of a few positions that together see most targets. The best choice of k of n candidates is hard to
// find (maximum coverage is NP-hard). Choosing each time the candidate that adds most reaches at least
// 1 - (1 - 1/k)^k > 1 - 1/e = 63 % of the best, and no fast algorithm has a better guarantee. Sources:
// Nemhauser, Wolsey, Fisher, An analysis of approximations for maximizing submodular set functions, 1978;
// Feige, A threshold of ln n for approximating set cover, 1998. Results are mostly far better than that,
// as the bound below shows (Leskovec et al., Cost-effective outbreak detection in networks, 2007).

struct ChosenPosition {
  std::size_t candidate = 0;
  double gain = 0.0;     ///< weight of the targets that no earlier one sees
  double covered = 0.0;  ///< weight of the targets that it and the earlier ones see
};

struct Placement {
  std::vector<ChosenPosition> positions;  ///< in the order they were chosen; `covered` is the curve
  double total = 0.0;                     ///< weight of all targets
  /// Upper bound: no choice of as many positions as requested covers more. The best choice may cover less; at
  /// least 1 - 1/e of what it covers is covered.
  double best_possible = 0.0;
};

/// Chooses up to `count` candidates one by one, each the one with the largest gain, of equal ones that with
/// the lowest number; fewer if more would gain nothing. `weights` of the targets; empty: 1 each. Lazy: gains
/// never grow, so a gain is computed again only when the last one would win (Minoux 1978). Cost: a pass
/// over the bits, some rows more per position, and a pass for the bound after 1, 2, 4, ... positions. Errors:
/// count 0; weights not as many as targets, negative or not finite.
Placement choose_places(const Coverage& coverage, std::size_t count, std::span<const double> weights = {});

/// The chosen positions in their order, and with them the curve of what they cover: `place` from 1,
/// `candidate` (its number, from 0), `name`, `x`, `y`, `z` of the eye, `gain` and `covered` (weights of
/// targets, 1 each by default), `share` (of all).
std::vector<Row> placement_rows(const Placement& placement, std::span<const Observer> candidates);

/// Writes placement_rows(). CSV; JSON with the list `places`; or GeoJSON with points,
/// which other commands read as observers. Coordinates, returned value and Errors as write_positions().
bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite);

}  // namespace alidade::visibility
