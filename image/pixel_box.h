// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace alidade::image {

/// Pixels [left, right) x [top, bottom); row 0 is on top.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;

  int width() const { return right - left; }
  int height() const { return bottom - top; }
  std::size_t count() const { return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()); }
  bool operator==(const PixelBox&) const = default;
};

}  // namespace alidade::image
