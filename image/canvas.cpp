// SPDX-License-Identifier: MIT
#include "image/canvas.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alidade::image {

Rgb8 to_rgb8(const glm::dvec3& display) {
  const auto channel = [](double value) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
  };
  return {channel(display.r), channel(display.g), channel(display.b)};
}

Canvas::Canvas(int width, int height, const Rgb8& background) : width_(width), height_(height) {
  assert(width > 0 && height > 0);
  bytes_.resize(std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  fill({0, 0, width, height}, background);
}

std::size_t Canvas::offset(int x, int y) const {
  return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
}

Rgb8 Canvas::at(int x, int y) const {
  assert(x >= 0 && x < width_ && y >= 0 && y < height_);
  const std::size_t first = offset(x, y);
  return {bytes_[first], bytes_[first + 1], bytes_[first + 2]};
}

void Canvas::fill(const PixelBox& box, const Rgb8& color) {
  const int left = std::max(box.left, 0), right = std::min(box.right, width_);
  for (int y = std::max(box.top, 0); y < std::min(box.bottom, height_); ++y) {
    for (int x = left; x < right; ++x)
      std::ranges::copy(color, bytes_.begin() + static_cast<std::ptrdiff_t>(offset(x, y)));
  }
}

void Canvas::blend(int x, int y, const Rgb8& color, int cover) {
  constexpr int k_full = 255;
  if (x < 0 || x >= width_ || y < 0 || y >= height_) return;
  std::uint8_t* const pixel = bytes_.data() + offset(x, y);
  for (std::size_t i = 0; i < color.size(); ++i) {
    pixel[i] =
        static_cast<std::uint8_t>((pixel[i] * (k_full - cover) + color[i] * cover + k_full / 2) / k_full);
  }
}

void Canvas::frame(const PixelBox& box, const Rgb8& color) {
  fill({box.left, box.top, box.right, box.top + 1}, color);
  fill({box.left, box.bottom - 1, box.right, box.bottom}, color);
  fill({box.left, box.top, box.left + 1, box.bottom}, color);
  fill({box.right - 1, box.top, box.right, box.bottom}, color);
}

}  // namespace alidade::image
