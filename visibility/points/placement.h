// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "image/canvas.h"
#include "image/font.h"
#include "visibility/points/coverage.h"
#include "visibility/row_text.h"

// A choice of a few positions that together see most targets. The best choice of k of n candidates is hard to
// find (maximum coverage is NP-hard). Choosing each time the candidate that adds most reaches at least
// 1 - (1 - 1/k)^k > 1 - 1/e = 63 % of the best, and no fast algorithm has a better guarantee. Sources:
// Nemhauser, Wolsey, Fisher, An analysis of approximations for maximizing submodular set functions, 1978;
// Feige, A threshold of ln n for approximating set cover, 1998. Results are mostly far better than that,
// as the bound below shows (Leskovec et al., Cost-effective outbreak detection in networks, 2007).

namespace alidade::visibility {

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

/// Writes the chosen positions in their order, and with them the curve of what they cover: `place` from 1,
/// `candidate` (its number, from 0), `name`, `x`, `y`, `z` of the eye, `gain` and `covered` (weights of
/// targets, 1 each by default), `share` (of all). CSV; JSON with the list `places`; or GeoJSON with points,
/// which other commands read as observers. Coordinates, returned value and Errors as write_positions().
bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite);

/// The curve of what the positions cover: a bar per position in the order they were chosen, its height the
/// share of all targets in percent, its gain in a darker tone; a line at Placement::best_possible.
/// Black on white, 900 by 560 pixels. Requires at least one position and a total above 0.
image::Canvas draw_coverage(const Placement& placement, const image::Font& font);

/// Writes the image of draw_coverage() as PNG, with the font of find_font(). Errors: those of
/// find_font() and write_png().
void write_coverage_image(const Placement& placement, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
