// SPDX-License-Identifier: MIT
#include "compare/orientation.h"

#include <utility>

namespace alidade {
namespace {

/// How to go through the stored picture so as to meet its pixels in upright order.
struct Walk {
  bool is_turned;                     ///< rows and columns change places
  std::ptrdiff_t first, right, down;  ///< in pixels of the stored picture
};

Walk walk_of(int orientation, std::ptrdiff_t width, std::ptrdiff_t height) {
  const std::ptrdiff_t last_column = width - 1, last_row = (height - 1) * width;
  switch (orientation) {
    case 2:
      return {false, last_column, -1, width};
    case 3:
      return {false, last_row + last_column, -1, -width};
    case 4:
      return {false, last_row, 1, -width};
    case 5:
      return {true, 0, width, 1};
    case 6:
      return {true, last_row, -width, 1};
    case 7:
      return {true, last_row + last_column, -width, -1};
    case 8:
      return {true, last_column, width, -1};
    default:
      return {false, 0, 1, width};
  }
}

template <typename Value>
void turn(std::vector<Value>& values, const Walk& walk, std::ptrdiff_t width, std::ptrdiff_t height,
          std::ptrdiff_t components) {
  if (values.empty()) return;
  std::vector<Value> turned;
  turned.reserve(values.size());
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      const auto begin = values.begin() + (walk.first + x * walk.right + y * walk.down) * components;
      turned.insert(turned.end(), begin, begin + components);
    }
  }
  values = std::move(turned);
}

}  // namespace

void turn_upright(ComparedImage& image, int orientation) {
  if (orientation < 2 || orientation > 8) return;
  const Walk walk = walk_of(orientation, image.width, image.height);
  if (walk.is_turned) {
    std::swap(image.width, image.height);
    std::swap(image.origin_x, image.origin_y);
  }
  const std::ptrdiff_t width = image.width, height = image.height;
  turn(image.color, walk, width, height, 3);
  turn(image.alpha, walk, width, height, 1);
  turn(image.depth, walk, width, height, 1);
  turn(image.normals, walk, width, height, 3);
  turn(image.ids, walk, width, height, 1);
}

}  // namespace alidade
