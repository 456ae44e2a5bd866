// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geo/raster.h"
#include "image/canvas.h"
#include "image/color_map.h"
#include "image/font.h"
#include "image/point_color.h"
#include "visibility/raster/ground.h"

namespace alidade::visibility {

/// Shading of the ground by a light in the north-west, 45 degrees high. Heights are
/// exaggerated if the land is flat.
class Relief {
 public:
  /// `step`: slopes are differences over twice this length, about a pixel of the image. Cost: that of about
  /// 10 000 heights.
  Relief(const Ground& ground, double step);

  /// Brightness at a position: 1 if it is level or has no ground around it, from 0 in the shade to
  /// about 1.4 towards the light.
  double light(const glm::dvec2& position) const;

 private:
  glm::dvec2 slope(const glm::dvec2& position) const;

  const Ground& ground_;
  double step_;
  double exaggeration_ = 1.0;
};

// A map as an image: values as colours over the shaded relief of the ground, north up, with the
// observers, a scale bar and a legend.

/// The colour and meaning of one value.
struct MapSwatch {
  float value = 0.0f;
  image::Rgb8 color{};
  std::string label;
};

/// The colours of values without a swatch, from low to high.
struct MapScale {
  image::ColorMap map = image::ColorMap::viridis;
  image::ValueRange range{};
  std::string label;  ///< what the numbers are, with their unit
  int most_ticks = 7;
};

/// A position with a name.
struct MapMark {
  glm::dvec2 position{0.0};
  std::string name{};  ///< empty: only the mark
};

struct MapImage {
  std::string title;
  geo::Raster<float> values;  ///< NaN: nothing is drawn
  std::vector<MapSwatch> swatches{};
  std::optional<MapScale> scale{};
  std::vector<MapMark> marks{};  ///< those outside of the map are not drawn
  std::string unit{};            ///< of lengths on the map: "m", "ft" or empty
  std::vector<std::string> notes{};
};

/// Draws the map, the longer side of its grid about `longest_side` pixels long (whole pixels per cell if
/// there are more pixels than cells). The legend names the swatches that occur, with their share of the
/// cells with a value. The same pixels for the same map, font and version of FreeType. Requires
/// longest_side >= 1.
image::Canvas draw_map(const MapImage& image, const Ground& ground, const image::Font& font,
                       int longest_side = 1000);

/// Writes the image of draw_map() as PNG. Errors: those of write_png() and find_font().
void write_map_image(const MapImage& image, const Ground& ground, const std::filesystem::path& file,
                     bool overwrite);

}  // namespace alidade::visibility
