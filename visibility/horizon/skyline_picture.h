// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "image/canvas.h"
#include "image/font.h"
#include "visibility/horizon/skyline.h"

namespace alidade {

/// The skyline as people plot it: azimuth to the right, elevation up, what is seen coloured by distance (dark
/// is near, on a logarithmic scale with a bar beside), the horizon line in red over it. Requires a strip that
/// is filled.
Canvas draw_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                    const SkylineTexts& texts, const Font& font);

/// Writes it as PNG, with the font of find_font(). The file appears whole or not at all. Errors: as
/// write_png() (image/image_file.h); no font.
void write_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                   const SkylineTexts& texts, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade
