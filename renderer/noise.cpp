// SPDX-License-Identifier: MIT
#include "renderer/noise.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "image/srgb.h"

namespace alidade::renderer {
namespace {

const glm::dvec3 k_luminance{0.2126, 0.7152, 0.0722};

/// Variance of the mean of the first 2^j samples, summed over a tile, for j from 0 to one level beyond the
/// samples there are.
class LevelVariances {
 public:
  /// samples >= 2.
  LevelVariances(const LevelSums& levels, std::uint32_t samples) {
    const auto top = static_cast<std::size_t>(std::bit_width(samples) - 1);
    const double last = levels[top - 1], before = top >= 2 ? levels[top - 2] : 2.0 * last;
    // At the top level the slow part s and the fast part f: last = s + 7 f, before = 2 s + 56 f.
    const double fast = std::min((before - 2.0 * last) / 42.0, last / 7.0), slow = last - 7.0 * fast;
    variances_[top + 1] = slow / 2.0 + fast / 8.0;
    variances_[top] = slow + fast;
    for (std::size_t j = top; j-- > 0;) variances_[j] = variances_[j + 1] + levels[j];
  }

  double of_one() const { return variances_[0]; }

  /// Of the first n samples, n below twice the samples there are.
  double of(std::uint32_t n) const {
    if (n == 0) return 0.0;
    const auto level = static_cast<std::size_t>(std::bit_width(n) - 1);
    const std::uint32_t block = std::uint32_t{1} << level, rest = n - block;
    if (rest == 0) return variances_[level];
    // The rest are the first samples of the block's twin. Their covariance with the block is that of the two
    // blocks: 2 V(level + 1) - V(level).
    const double b = block, r = rest, covariance = 2.0 * variances_[level + 1] - variances_[level];
    const double sum = b * b * variances_[level] + r * r * of(rest) + 2.0 * b * r * covariance;
    // Twice the block is better still.
    return std::max(sum / (static_cast<double>(n) * n), variances_[level + 1]);
  }

 private:
  std::array<double, LevelSums().size() + 2> variances_{};
};

/// Variance of the mean over what independent samples would leave. samples >= 2.
double variance_share(const LevelSums& levels, std::uint32_t samples) {
  constexpr double k_largest_share = 2.0;
  const LevelVariances variances(levels, samples);
  // With two samples, or without any difference, there is nothing to distinguish them.
  if (samples == 2 || !(variances.of_one() > 0.0)) return 1.0;
  return std::clamp(samples * variances.of(samples) / variances.of_one(), 0.0, k_largest_share);
}

/// From the sum of squared differences to the variance of the mean. The sum over n is on average V(one) -
/// V(n), the sample variance less what the mean has taken along.
double scale_of(double share, double samples) {
  return share / (samples * (samples - share));
}

/// The noise of a tile and its neighbours together.
Noise noise_around(const TileGrid& grid, const std::vector<Noise>& noise, std::size_t tile) {
  const int column = grid.column_of(tile), row = grid.row_of(tile);
  Noise sum;
  for (int r = std::max(0, row - 1); r <= std::min(grid.rows() - 1, row + 1); ++r)
    for (int c = std::max(0, column - 1); c <= std::min(grid.columns() - 1, column + 1); ++c)
      sum += noise[grid.tile_at(c, r)];
  return sum;
}

}  // namespace

double mean_variance_scale(const LevelSums& levels, std::uint32_t samples) {
  assert(samples >= 2);
  return scale_of(variance_share(levels, samples), samples);
}

Noise& Noise::operator+=(const Noise& other) {
  variance += other.variance;
  luminance += other.luminance;
  pixels += other.pixels;
  return *this;
}

double Noise::error(double floor) const {
  if (pixels == 0) return 0.0;
  const auto count = static_cast<double>(pixels);
  return std::sqrt(variance / count) / (luminance / count + floor);
}

Noise tile_noise(const ImageState& state, std::size_t tile) {
  constexpr double k_caution = 4.0;
  const image::PixelBox box = state.grid.box(tile);
  const SumBand& band = state.bands[static_cast<std::size_t>(state.grid.row_of(tile))];
  double sum = 0.0, sum_of_squares = 0.0;
  Noise noise;
  noise.pixels = box.count();
  for (int y = 0; y < box.height(); ++y) {
    std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(state.grid.width()) +
                        static_cast<std::size_t>(box.left);
    for (int x = 0; x < box.width(); ++x, ++pixel) {
      double deviation = 0.0;
      for (int channel = 0; channel < 3; ++channel) {
        deviation += k_luminance[channel] * std::sqrt(static_cast<double>(band.squares[pixel][channel]));
        noise.luminance += k_luminance[channel] * band.mean[pixel][channel];
      }
      const double square = deviation * deviation;
      sum += square;
      sum_of_squares += square * square;
    }
  }
  const std::uint32_t samples = state.tiles[tile].samples;
  if (samples < 2) noise.variance = std::numeric_limits<double>::infinity();
  if (samples < 2 || !(sum_of_squares > 0.0)) return noise;
  const double weight = sum * sum / sum_of_squares;
  const double share =
      (weight * variance_share(state.levels[tile], samples) + k_caution) / (weight + k_caution);
  noise.variance = sum * scale_of(share, samples);
  return noise;
}

void StopRule::apply(ImageState& state) {
  noise_.resize(state.tiles.size());
  in_parallel(state.tiles.size(), 16, [&](std::size_t tile) {
    // Tiles that have stopped stay as they are.
    if (!state.tiles[tile].stopped || noise_[tile].pixels == 0) noise_[tile] = tile_noise(state, tile);
  });
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    TileState& reached = state.tiles[tile];
    reached.stopped =
        reached.stopped || (reached.samples >= k_fewest_samples && noise_[tile].error(floor_) <= target_ &&
                            noise_around(state.grid, noise_, tile).error(floor_) <= target_);
  }
}

double StopRule::expected_samples(const ImageState& state, std::size_t tile, double most) const {
  const TileState& reached = state.tiles[tile];
  const double samples = reached.samples;
  if (reached.stopped || noise_.empty()) return reached.stopped ? samples : most;
  const double factor = noise_[tile].error(floor_) / target_;
  return std::clamp(samples * factor * factor, std::min(samples + 1.0, most), most);
}

double noise_floor(double exposure) {
  return 0.01 / image::exposure_scale(exposure);
}

ReachedNoise reached_noise(const ImageState& state, double floor) {
  std::vector<double> errors(state.tiles.size());
  in_parallel(errors.size(), 16,
              [&](std::size_t tile) { errors[tile] = tile_noise(state, tile).error(floor); });
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::ranges::nth_element(errors, middle);
  return {*middle, *std::ranges::max_element(errors)};
}

}  // namespace alidade::renderer
