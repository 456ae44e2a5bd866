// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "image/canvas.h"
#include "image/font.h"
#include "visibility/points/placement.h"

namespace alidade {

/// How much more each further place covers: a bar per place in the order they were chosen, its height the
/// share of all targets in percent, what the place adds in a darker tone; a line where no choice of as many
/// places can be. Black on white, 900 by 560 pixels. Requires at least one place and a total above 0.
Canvas draw_coverage(const Placement& placement, const Font& font);

/// Writes it as PNG, with the font of find_font(). Errors: those of find_font() and write_png().
void write_coverage_picture(const Placement& placement, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade
