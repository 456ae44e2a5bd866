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

// The few positions from which one sees most. Which k of n candidates see most targets together is hard to
// answer exactly (maximum coverage is NP-hard). Taking each time the candidate that sees most of what nobody
// sees yet gives at least 1 - (1 - 1/k)^k > 1 - 1/e = 63 % of the best, and no fast way is surely better.
// Sources: Nemhauser, Wolsey, Fisher, An analysis of approximations for maximizing submodular set functions,
// 1978; Feige, A threshold of ln n for approximating set cover, 1998. What is found is mostly far better than
// that, as the bound below shows (Leskovec et al., Cost-effective outbreak detection in networks, 2007).

namespace alidade::visibility {

struct ChosenPosition {
  std::size_t candidate = 0;
  double gain = 0.0;     ///< weight of the targets that none before it sees
  double covered = 0.0;  ///< weight of all that it and those before it see
};

struct Placement {
  std::vector<ChosenPosition> positions;  ///< in the order they were chosen; `covered` is the curve
  double total = 0.0;                     ///< weight of all targets
  /// No choice of as many positions as asked for covers more. (What the best choice covers may be less than
  /// this; of that at least 1 - 1/e is covered.)
  double best_possible = 0.0;
};

/// Chooses up to `count` candidates one by one, each the one with the largest gain, of equal ones that with
/// the lowest number; fewer if more would gain nothing. `weights` of the targets; empty: 1 each. Lazy: gains
/// only fall, so a candidate is weighed again only when its last gain would win (Minoux 1978). Cost: a pass
/// over the bits, some rows more per position, and a pass for the bound after 1, 2, 4, ... positions. Errors:
/// count 0; weights not as many as targets, negative or not finite.
Placement choose_places(const Coverage& coverage, std::size_t count, std::span<const double> weights = {});

/// Writes the chosen positions in their order, and with them the curve of what they cover: `position` from 1,
/// `candidate` (its number, from 0), `name`, `x`, `y`, `z` of the eye, `gain` and `covered` (weights of
/// targets, 1 each unless weighed), `share` (of all). CSV; JSON with the list `positions`; or GeoJSON with
/// points, which other commands read as observers. Coordinates, answer and Errors as write_lines().
bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite);

/// How much more each further position covers: a bar per position in the order they were chosen, its height the
/// share of all targets in percent, what the position adds in a darker tone; a line where no choice of as many
/// positions can be. Black on white, 900 by 560 pixels. Requires at least one position and a total above 0.
image::Canvas draw_coverage(const Placement& placement, const image::Font& font);

/// Writes it as PNG, with the font of find_font(). Errors: those of find_font() and write_png().
void write_coverage_picture(const Placement& placement, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
