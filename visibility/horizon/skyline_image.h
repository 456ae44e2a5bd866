// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "image/canvas.h"
#include "image/font.h"
#include "visibility/horizon/skyline.h"

namespace alidade::visibility {

/// A line over the image, such as the path of the sun. Positions are azimuth and elevation, degrees; the
/// line is cut where the azimuth jumps by more than 180 degrees.
struct SkylineCurve {
  std::vector<glm::dvec2> positions;
  image::Rgb8 color{};
  double width = 2.0;   ///< pixels
  std::string label{};  ///< beside its highest point; empty: none
  struct Mark {
    glm::dvec2 position;
    std::string label;  ///< above the dot
  };
  std::vector<Mark> marks{};  ///< dots
};

/// Text around the image and curves over it.
struct SkylineTexts {
  std::string title;                   ///< above it
  std::string note;                    ///< below it
  std::string unit;                    ///< of distances: "m"; empty if unknown
  std::vector<SkylineCurve> curves{};  ///< faint where something hides them
};

/// The skyline as a plot: azimuth to the right, elevation up, coloured by distance (dark is near, on a
/// logarithmic scale with a bar beside it), the horizon line in red, curves bright over the sky and faint
/// over what hides them. Requires a filled strip.
image::Canvas draw_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                           const SkylineTexts& texts, const image::Font& font);

/// Writes the image of draw_skyline() as PNG, with the font of find_font(). The file is written completely
/// or not at all. Errors: as write_png() (image/image_file.h); no font.
void write_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                   const SkylineTexts& texts, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
