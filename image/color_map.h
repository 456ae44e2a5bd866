// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <string_view>

#include "cloud/attributes.h"

namespace alidade::image {

/// A way from numbers to colours.
enum class ColorMap {
  viridis,  ///< dark violet, green, yellow: even steps of lightness, also for the colour blind and in print
  inferno,  ///< black, red, yellow: even steps of lightness, a wider range of it
  turbo,    ///< the rainbow without false edges: many distinct colours, no even lightness
  terrain,  ///< meadow, straw, clay, rock, snow: tints of height that look well under light
  grey,     ///< dark to light grey, never black, which would hide all shape in the shade
};

/// A colour map and the word for it in scene files and on command lines.
struct NamedColorMap {
  std::string_view name;
  ColorMap map;
};

/// Every colour map, in the order of the enum.
inline constexpr std::array<NamedColorMap, 5> k_color_maps = {{{"viridis", ColorMap::viridis},
                                                               {"inferno", ColorMap::inferno},
                                                               {"turbo", ColorMap::turbo},
                                                               {"terrain", ColorMap::terrain},
                                                               {"grey", ColorMap::grey}}};

std::string_view name(ColorMap map);

/// Colour at a position in [0, 1], display-referred (sRGB); positions outside are taken as the nearest end,
/// NaN as the low one. Linear between even steps. viridis, inferno and turbo differ from the published tables
/// of 256 colours by at most 0.005 per channel (1.2 of 255). Sources: viridis and inferno: S. van der Walt,
/// N. Smith, E. Firing, matplotlib 1.5 (2015), CC0. turbo: A. Mikhailov, Turbo, An Improved Rainbow Colormap
/// for Visualization, Google AI Blog (2019), Apache-2.0.
glm::dvec3 map_color(ColorMap map, double position);

/// Display-referred values in [0, 1] as a point's colour, rounded to the nearest.
Color16 to_color16(const glm::dvec3& display);

}  // namespace alidade::image
