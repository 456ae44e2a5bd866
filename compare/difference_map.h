// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/compared_image.h"
#include "image/canvas.h"
#include "image/point_color.h"

// Maps of the differences of two images, as images.

namespace alidade::image {
class Font;
}

namespace alidade::compare {

/// Colours of a map.
enum class DifferenceColors {
  heat,     ///< black, red, yellow: how much
  balance,  ///< blue below, light grey at 0, red above: which way
};

/// Of pixels that do not count.
constexpr image::Rgb8 k_excluded_color{150, 150, 158};

/// A kind of pixels in a map without numbers.
struct MapCategory {
  image::Rgb8 color{};
  std::string label;
};

/// One value per pixel and its meaning.
struct DifferenceMap {
  std::string title;
  std::string label;  ///< what the numbers are, with their unit
  DifferenceColors colors = DifferenceColors::heat;
  image::ValueRange range{};  ///< values of the first and last colour
  /// Values are indices into this list, from no change to the strongest; empty: values are numbers.
  std::vector<MapCategory> categories{};
  int width = 0, height = 0;
  /// NaN: there is nothing to compare. Infinite: only one image has something there; plus the reference,
  /// minus the test (the other one's surface is infinitely far away).
  std::vector<float> values;
  ImageMask mask;                    ///< what does not count is not shown
  std::vector<std::string> notes{};  ///< lines of small print
};

/// The largest difference of the three channels, of display-referred colours, 0 .. 1 (of white). The range
/// ends at the 99.5th percentile, at least 1/255, at most 1.
DifferenceMap color_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask);

/// FLIP's own map (compare/metrics/flip.h), 0 .. 1.
DifferenceMap flip_difference(std::vector<float> flip, int width, const ImageMask& mask);

/// Test minus reference of the depth layers, metres: positive is farther away in the test. Where a value is
/// not is_depth(), there is nothing. The range is the 98th percentile of the magnitudes, to both sides, at
/// least 1 mm; what only one image has is distinguished. Both images must have depth and one size.
DifferenceMap depth_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask);

/// Where depths agree (green), differ (red) or are missing in a scan (light grey), black where neither image
/// has any (compare/metrics/agreement.h). Requires have_agreement() and one size.
DifferenceMap depth_agreement(const ComparedImage& reference, const ComparedImage& test,
                              const ImageMask& mask);

/// The map alone, a pixel for a pixel.
image::Canvas paint_difference(const DifferenceMap& map);

/// The map with title and legend, at most `longest_side` pixels long: of larger ones each pixel shows the
/// strongest value of a square. Equal pixels for equal map, font and version of FreeType. Requires
/// longest_side >= 1.
image::Canvas draw_difference(const DifferenceMap& map, const image::Font& font, int longest_side = 1600);

/// Writes draw_difference() as PNG, with the font of find_font(). Errors: those of write_png() and
/// find_font().
void write_difference(const DifferenceMap& map, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::compare
