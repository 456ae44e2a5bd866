// SPDX-License-Identifier: MIT
#include "compare/metrics/ssim.h"

#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "base/exact_math.h"
#include "base/parallel.h"
#include "compare/metrics/pixel_sums.h"

namespace alidade::compare {

namespace {

/// Reach of SSIM's window on each side, pixels.
constexpr int k_ssim_reach = 5;

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

/// One channel of a piece of two images, in double: variances are small differences of large numbers.
class SsimTile {
 public:
  static constexpr int k_most_width = 128, k_most_height = 64;

  SsimTile() {
    for (auto& values : values_) values.assign(std::size_t{k_pitch} * k_rows, 0.0);
    for (auto& means : means_) means.assign(std::size_t{k_most_width} * k_rows, 0.0);
  }
  void begin(int width, int height) {
    width_ = width;
    height_ = height;
  }
  int width() const { return width_; }
  int height() const { return height_; }
  int columns_with_margin() const { return width_ + 2 * k_ssim_reach; }
  int rows_with_margin() const { return height_ + 2 * k_ssim_reach; }

  /// Values of a row of an image (0 reference, 1 test), with k_ssim_reach more on each side; row 0 is the
  /// highest above the tile.
  double* values(int image, int row) {
    return values_[static_cast<std::size_t>(image)].data() + static_cast<std::ptrdiff_t>(row) * k_pitch;
  }

  /// Filters along the rows; to be called before similarities().
  void filter_rows() {
    double squares[k_pitch], products[k_pitch];
    for (int row = 0; row < rows_with_margin(); ++row) {
      const double* const x = values(0, row);
      const double* const y = values(1, row);
      for (int column = 0; column < columns_with_margin(); ++column) {
        squares[column] = x[column] * x[column] + y[column] * y[column];
        products[column] = x[column] * y[column];
      }
      const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(row) * k_most_width;
      filter(x + k_ssim_reach, 1, width_, means_[0].data() + offset);
      filter(y + k_ssim_reach, 1, width_, means_[1].data() + offset);
      filter(squares + k_ssim_reach, 1, width_, means_[2].data() + offset);
      filter(products + k_ssim_reach, 1, width_, means_[3].data() + offset);
    }
  }

  /// SSIM and its contrast and structure part of the pixels of a row; `width` of each.
  void similarities(int row, double* similarity, double* contrast) {
    constexpr double k_c1 = 0.01 * 0.01, k_c2 = 0.03 * 0.03;
    double means[4][k_most_width];
    for (std::size_t i = 0; i < 4; ++i) {
      const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(row + k_ssim_reach) * k_most_width;
      filter(means_[i].data() + offset, k_most_width, width_, means[i]);
    }
    for (int x = 0; x < width_; ++x) {
      const double product = means[0][x] * means[1][x];
      const double squares = means[0][x] * means[0][x] + means[1][x] * means[1][x];
      contrast[x] = (2.0 * (means[3][x] - product) + k_c2) / (means[2][x] - squares + k_c2);
      similarity[x] = (2.0 * product + k_c1) / (squares + k_c1) * contrast[x];
    }
  }

 private:
  static constexpr int k_pitch = k_most_width + 2 * k_ssim_reach;
  static constexpr int k_rows = k_most_height + 2 * k_ssim_reach;

  int width_ = 0, height_ = 0;
  std::array<std::vector<double>, 2> values_;
  /// Means of x, y, x^2 + y^2 and x y along rows.
  std::array<std::vector<double>, 4> means_;
};

constexpr int k_scales = 5;
constexpr int k_shortest_side = 161;  ///< 161, 81, 41, 21, 11

struct Means {
  double similarity[3] = {}, contrast[3] = {};
};

/// Sums of one tile; added up in the tiles' order.
struct Sums : Means {
  std::uint64_t count = 0;
};

/// Room for a tile.
struct Room {
  std::vector<PairPixels::Pair> pairs;  ///< of the tile and what its windows reach
  SsimTile tile;
};

/// The similarity of the images that `pixels` has, pair by pair.
template <class Pixels>
struct Windows {
  const Pixels& pixels;
  int width, height;
  const ImageMask& counted;

  /// NaN without a window that counts.
  Means run() const {
    const int across = (width + SsimTile::k_most_width - 1) / SsimTile::k_most_width;
    const int tiles = across * ((height + SsimTile::k_most_height - 1) / SsimTile::k_most_height);
    std::vector<Sums> sums(static_cast<std::size_t>(tiles));
    tbb::enumerable_thread_specific<Room> rooms;
    in_parallel(tiles, 1, [&](int i) {
      Room& room = rooms.local();
      const int left = i % across * SsimTile::k_most_width, top = i / across * SsimTile::k_most_height;
      room.tile.begin(std::min(SsimTile::k_most_width, width - left),
                      std::min(SsimTile::k_most_height, height - top));
      load(room, left, top);
      for (int channel = 0; channel < 3; ++channel)
        add_channel(room, left, top, channel, sums[static_cast<std::size_t>(i)]);
    });
    return means(sums);
  }

  /// Windows that reach beyond the image do not count, whatever the values there.
  void load(Room& room, int left, int top) const {
    room.pairs.clear();
    for (int row = 0; row < room.tile.rows_with_margin(); ++row) {
      const int y = std::clamp(top + row - k_ssim_reach, 0, height - 1);
      for (int column = 0; column < room.tile.columns_with_margin(); ++column)
        room.pairs.push_back(
            pixels.at(pixel_index(std::clamp(left + column - k_ssim_reach, 0, width - 1), y, width)));
    }
  }

  void add_channel(Room& room, int left, int top, int channel, Sums& sums) const {
    SsimTile& tile = room.tile;
    const PairPixels::Pair* pair = room.pairs.data();
    for (int row = 0; row < tile.rows_with_margin(); ++row) {
      for (int column = 0; column < tile.columns_with_margin(); ++column, ++pair) {
        tile.values(0, row)[column] = pair->color[0][channel];
        tile.values(1, row)[column] = pair->color[1][channel];
      }
    }
    tile.filter_rows();
    double similarity[SsimTile::k_most_width], contrast[SsimTile::k_most_width];
    for (int row = 0; row < tile.height(); ++row) {
      tile.similarities(row, similarity, contrast);
      const int y = top + row;
      for (int column = 0; column < tile.width(); ++column) {
        const int x = left + column;
        const bool is_inside =
            x >= k_ssim_reach && x < width - k_ssim_reach && y >= k_ssim_reach && y < height - k_ssim_reach;
        if (!is_inside || !counted.at(pixel_index(x, y, width))) continue;
        sums.similarity[channel] += similarity[column];
        sums.contrast[channel] += contrast[column];
        if (channel == 0) ++sums.count;
      }
    }
  }

  static Means means(const std::vector<Sums>& sums) {
    Means means;
    std::uint64_t count = 0;
    for (const Sums& one : sums) {
      count += one.count;
      for (int channel = 0; channel < 3; ++channel) {
        means.similarity[channel] += one.similarity[channel];
        means.contrast[channel] += one.contrast[channel];
      }
    }
    const double divisor = count == 0 ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(count);
    for (int channel = 0; channel < 3; ++channel) {
      means.similarity[channel] /= divisor;
      means.contrast[channel] /= divisor;
    }
    return means;
  }
};

/// Two images at half the size of two others.
struct HalfImages {
  int width = 0, height = 0;
  std::vector<PairPixels::Pair> pairs;
  ImageMask counted;

  const PairPixels::Pair& at(std::size_t pixel) const { return pairs[pixel]; }
};

template <class Pixels>
HalfImages halved(const Pixels& pixels, int width, int height, const ImageMask& counted) {
  HalfImages half{.width = (width + 1) / 2, .height = (height + 1) / 2, .pairs = {}, .counted = {}};
  const std::size_t count = static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height);
  half.pairs.resize(count);
  if (!counted.counts.empty()) half.counted.counts.assign(count, 1);
  in_parallel(half.height, 16, [&](int y) {
    for (int x = 0; x < half.width; ++x) {
      const std::size_t to = pixel_index(x, y, half.width);
      for (int part = 0; part < 4; ++part) {
        const std::size_t from =
            pixel_index(std::min(2 * x + part % 2, width - 1), std::min(2 * y + part / 2, height - 1), width);
        const auto pair = pixels.at(from);
        for (int image = 0; image < 2; ++image)
          for (int channel = 0; channel < 3; ++channel)
            half.pairs[to].color[image][channel] += 0.25f * pair.color[image][channel];
        if (!counted.at(from)) half.counted.counts[to] = 0;
      }
    }
  });
  return half;
}

/// value^weight for value in [0, 1].
double weighted(double value, double weight) {
  if (!(value > 0.0)) return value <= 0.0 ? 0.0 : value;
  return value >= 1.0 ? 1.0 : exponential(weight * std::numbers::ln2 * binary_logarithm(value));
}

double mean_of(const double (&channels)[3]) {
  return (channels[0] + channels[1] + channels[2]) / 3.0;
}

}  // namespace

Similarity similarity(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_colors(reference, test, "SSIM requires colours");
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  const PairPixels pixels(reference, test, counted, ColorEncoding::display);
  Means means = Windows<PairPixels>{pixels, reference.width, reference.height, counted}.run();
  Similarity result{.ssim = mean_of(means.similarity)};
  if (std::min(reference.width, reference.height) < k_shortest_side) return result;

  constexpr double k_weights[k_scales] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  double products[3] = {1.0, 1.0, 1.0};
  HalfImages half = halved(pixels, reference.width, reference.height, counted);
  for (int scale = 0; scale < k_scales; ++scale) {
    const bool is_last = scale == k_scales - 1;
    if (scale > 0) means = Windows<HalfImages>{half, half.width, half.height, half.counted}.run();
    if (scale > 0 && !is_last) half = halved(half, half.width, half.height, half.counted);
    for (int channel = 0; channel < 3; ++channel)
      products[channel] *=
          weighted(is_last ? means.similarity[channel] : means.contrast[channel], k_weights[scale]);
  }
  result.ms_ssim = mean_of(products);
  return result;
}

}  // namespace alidade::compare
