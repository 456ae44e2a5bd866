// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "extensions/placement/placement.h"
#include "image/canvas.h"
#include "image/font.h"

namespace alidade::visibility {

/// The curve of what the positions cover: a bar per position in the order they were chosen, its height the
/// share of all targets in percent, its gain in a darker tone; a line at Placement::best_possible.
/// Black on white, 900 by 560 pixels. Requires at least one position and a total above 0.
image::Canvas draw_coverage(const Placement& placement, const image::Font& font);

/// Writes the image of draw_coverage() as PNG, with the font of find_font(). Errors: those of
/// find_font() and write_png().
void write_coverage_image(const Placement& placement, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
