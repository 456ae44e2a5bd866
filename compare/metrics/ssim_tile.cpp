// SPDX-License-Identifier: MIT
#include "compare/metrics/ssim_tile.h"

#include "base/exact_math.h"

namespace alidade {
namespace {

/// A Gaussian of deviation 1.5 and sum 1: the tap of the centre, then of pixels 1 .. 5 away.
std::array<double, k_ssim_reach + 1> window_taps() {
  std::array<double, k_ssim_reach + 1> taps{};
  double sum = 0.0;
  for (int k = k_ssim_reach; k >= 0; --k) {
    const double tap = exponential(-0.5 * k * k / (1.5 * 1.5));
    taps[static_cast<std::size_t>(k)] = tap;
    sum += k == 0 ? tap : 2.0 * tap;
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

const std::array<double, k_ssim_reach + 1>& taps() {
  static const auto window = window_taps();
  return window;
}

/// to[x] = the window over from[x], with neighbours `step` apart.
void filter(const double* __restrict from, std::ptrdiff_t step, int width, double* __restrict to) {
  const double t0 = taps()[0], t1 = taps()[1], t2 = taps()[2], t3 = taps()[3], t4 = taps()[4], t5 = taps()[5];
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const double* const at = from + x;
    to[x] = t0 * at[0] + t1 * (at[-step] + at[step]) + t2 * (at[-2 * step] + at[2 * step]) +
            t3 * (at[-3 * step] + at[3 * step]) + t4 * (at[-4 * step] + at[4 * step]) +
            t5 * (at[-5 * step] + at[5 * step]);
  }
}

}  // namespace

SsimTile::SsimTile() {
  for (auto& values : values_) values.assign(std::size_t{k_pitch} * k_rows, 0.0);
  for (auto& means : means_) means.assign(std::size_t{k_most_width} * k_rows, 0.0);
}

void SsimTile::filter_rows() {
  double squares[k_pitch], products[k_pitch];
  for (int row = 0; row < rows_with_margin(); ++row) {
    const double* const x = values(0, row);
    const double* const y = values(1, row);
    for (int column = 0; column < columns_with_margin(); ++column) {
      squares[column] = x[column] * x[column] + y[column] * y[column];
      products[column] = x[column] * y[column];
    }
    const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(row) * k_most_width;
    filter(x + k_ssim_reach, 1, width_, means_[0].data() + place);
    filter(y + k_ssim_reach, 1, width_, means_[1].data() + place);
    filter(squares + k_ssim_reach, 1, width_, means_[2].data() + place);
    filter(products + k_ssim_reach, 1, width_, means_[3].data() + place);
  }
}

void SsimTile::similarities(int row, double* similarity, double* contrast) {
  constexpr double k_c1 = 0.01 * 0.01, k_c2 = 0.03 * 0.03;
  double means[4][k_most_width];
  for (std::size_t i = 0; i < 4; ++i) {
    const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(row + k_ssim_reach) * k_most_width;
    filter(means_[i].data() + place, k_most_width, width_, means[i]);
  }
  for (int x = 0; x < width_; ++x) {
    const double product = means[0][x] * means[1][x];
    const double squares = means[0][x] * means[0][x] + means[1][x] * means[1][x];
    contrast[x] = (2.0 * (means[3][x] - product) + k_c2) / (means[2][x] - squares + k_c2);
    similarity[x] = (2.0 * product + k_c1) / (squares + k_c1) * contrast[x];
  }
}

}  // namespace alidade
