// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "image/pixel_box.h"

namespace alidade::image {

/// 8-bit red, green, blue; display-referred (sRGB).
using Rgb8 = std::array<std::uint8_t, 3>;

/// The nearest code of a display-referred colour, whose channels are clamped to 0 .. 1.
Rgb8 to_rgb8(const glm::dvec3& display);

/// An image to draw on: legends, maps, reports. What is drawn outside of it is cut off.
class Canvas {
 public:
  /// Requires sides of at least 1 pixel.
  Canvas(int width, int height, const Rgb8& background);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Rows from top to bottom, three bytes per pixel.
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  Rgb8 at(int x, int y) const;
  void fill(const PixelBox& box, const Rgb8& color);
  /// Covers a part of a pixel: 0 leaves it as it is, 255 replaces it. Nothing outside of the canvas.
  void blend(int x, int y, const Rgb8& color, int cover);
  /// The outermost pixels of the box.
  void frame(const PixelBox& box, const Rgb8& color);

 private:
  std::size_t offset(int x, int y) const;  ///< of a pixel's bytes

  int width_, height_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace alidade::image
