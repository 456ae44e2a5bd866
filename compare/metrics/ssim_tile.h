// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace alidade {

/// Reach of SSIM's window on each side, pixels.
constexpr int k_ssim_reach = 5;

/// One channel of a piece of two pictures, in double: variances are small differences of large numbers.
class SsimTile {
 public:
  static constexpr int k_most_width = 128, k_most_height = 64;

  SsimTile();
  void begin(int width, int height) {
    width_ = width;
    height_ = height;
  }
  int width() const { return width_; }
  int height() const { return height_; }
  int columns_with_margin() const { return width_ + 2 * k_ssim_reach; }
  int rows_with_margin() const { return height_ + 2 * k_ssim_reach; }

  /// Values of a row of a picture (0 reference, 1 test), with k_ssim_reach more on each side; row 0 is the
  /// highest above the tile.
  double* values(int picture, int row) {
    return values_[static_cast<std::size_t>(picture)].data() + static_cast<std::ptrdiff_t>(row) * k_pitch;
  }
  /// Filters along the rows; to be called before similarities().
  void filter_rows();
  /// SSIM and its contrast and structure part of the pixels of a row; `width` of each.
  void similarities(int row, double* similarity, double* contrast);

 private:
  static constexpr int k_pitch = k_most_width + 2 * k_ssim_reach;
  static constexpr int k_rows = k_most_height + 2 * k_ssim_reach;

  int width_ = 0, height_ = 0;
  std::array<std::vector<double>, 2> values_;
  /// Means of x, y, x^2 + y^2 and x y along rows.
  std::array<std::vector<double>, 4> means_;
};

}  // namespace alidade
