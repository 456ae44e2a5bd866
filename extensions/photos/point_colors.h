// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "cloud/attributes.h"
#include "image/read_image.h"

// The colour of a point from the photos that see it.

namespace alidade::visibility {

/// Largest number of views, the finest ones, that make the colour of a point.
constexpr std::size_t k_color_views = 5;

/// What a photo shows of a point.
struct ColorView {
  float weight = -1.0f;  ///< pixels per unit of area of the point's surface, >= 0; below 0: there is no view
  std::array<std::uint8_t, 3> color{};
};

/// The finest views of a point, by weight.
using ColorViews = std::array<ColorView, k_color_views>;

/// The colour at a position of a photo, interpolated between the centres of its pixels. Beyond the outermost
/// centres that of these. Requires a position inside the photo.
std::array<std::uint8_t, 3> color_at(const image::PhotoPixels& photo, const glm::dvec2& film_position);

/// Keeps a view if it is among the finest; of equal ones, those that were added first.
void add_view(const ColorView& view, ColorViews& views);

/// The weighted median of the views, channel by channel. Of two views it is their weighted mean, of one its
/// colour. A view weighs at most 0.9 times the sum of the others: of three views or more, none alone
/// decides, so that a wrong one (something in front of the camera, a reflection) does not show if the
/// others agree. Requires a view.
Color16 blended(const ColorViews& views);

}  // namespace alidade::visibility
