// SPDX-License-Identifier: MIT
#include "compare/metrics/ssim.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "base/exact_math.h"
#include "compare/metrics/pair_pixels.h"
#include "compare/metrics/ssim_tile.h"

namespace alidade {
namespace {

constexpr int k_scales = 5;
constexpr int k_shortest_side = 161;  ///< 161, 81, 41, 21, 11

/// Sums of one tile; added up in the tiles' order.
struct Sums {
  double similarity[3] = {}, contrast[3] = {};
  std::uint64_t count = 0;
};

struct Means {
  double similarity[3] = {}, contrast[3] = {};
};

/// Room for a tile.
struct Room {
  std::vector<PairPixels::Pair> pairs;  ///< of the tile and what its windows reach
  SsimTile tile;
};

/// The similarity of the pictures that `pixels` has, pair by pair.
template <class Pixels>
class Windows {
 public:
  Windows(const Pixels& pixels, int width, int height, const ImageMask& counted)
      : pixels_(pixels), width_(width), height_(height), counted_(counted) {}

  /// NaN without a window that counts.
  Means run() {
    const int across = (width_ + SsimTile::k_most_width - 1) / SsimTile::k_most_width;
    const int tiles = across * ((height_ + SsimTile::k_most_height - 1) / SsimTile::k_most_height);
    std::vector<Sums> sums(static_cast<std::size_t>(tiles));
    tbb::enumerable_thread_specific<Room> rooms;
    tbb::parallel_for(tbb::blocked_range<int>(0, tiles, 1), [&](const auto& range) {
      Room& room = rooms.local();
      for (int i = range.begin(); i != range.end(); ++i) {
        const int left = i % across * SsimTile::k_most_width, top = i / across * SsimTile::k_most_height;
        room.tile.begin(std::min(SsimTile::k_most_width, width_ - left),
                        std::min(SsimTile::k_most_height, height_ - top));
        load(room, left, top);
        for (int channel = 0; channel < 3; ++channel)
          add_channel(room, left, top, channel, sums[static_cast<std::size_t>(i)]);
      }
    });
    return means(sums);
  }

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  /// Windows that reach beyond the picture do not count, whatever stands there.
  void load(Room& room, int left, int top) const {
    room.pairs.clear();
    for (int row = 0; row < room.tile.rows_with_margin(); ++row) {
      const int y = std::clamp(top + row - k_ssim_reach, 0, height_ - 1);
      for (int column = 0; column < room.tile.columns_with_margin(); ++column)
        room.pairs.push_back(pixels_.at(at(std::clamp(left + column - k_ssim_reach, 0, width_ - 1), y)));
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
            x >= k_ssim_reach && x < width_ - k_ssim_reach && y >= k_ssim_reach && y < height_ - k_ssim_reach;
        if (!is_inside || !counted_.at(at(x, y))) continue;
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

  const Pixels& pixels_;
  const int width_, height_;
  const ImageMask& counted_;
};

/// Two pictures at half the size of two others.
struct HalfPictures {
  int width = 0, height = 0;
  std::vector<PairPixels::Pair> pairs;
  ImageMask counted;

  const PairPixels::Pair& at(std::size_t pixel) const { return pairs[pixel]; }
};

template <class Pixels>
HalfPictures halved(const Pixels& pixels, int width, int height, const ImageMask& counted) {
  HalfPictures half{.width = (width + 1) / 2, .height = (height + 1) / 2, .pairs = {}, .counted = {}};
  const std::size_t count = static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height);
  half.pairs.resize(count);
  if (!counted.counts.empty()) half.counted.counts.assign(count, 1);
  tbb::parallel_for(tbb::blocked_range<int>(0, half.height, 16), [&](const auto& range) {
    for (int y = range.begin(); y != range.end(); ++y) {
      for (int x = 0; x < half.width; ++x) {
        const std::size_t to =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(half.width) + static_cast<std::size_t>(x);
        for (int part = 0; part < 4; ++part) {
          const int from_x = std::min(2 * x + part % 2, width - 1),
                    from_y = std::min(2 * y + part / 2, height - 1);
          const std::size_t from = static_cast<std::size_t>(from_y) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(from_x);
          const auto pair = pixels.at(from);
          for (int picture = 0; picture < 2; ++picture)
            for (int channel = 0; channel < 3; ++channel)
              half.pairs[to].color[picture][channel] += 0.25f * pair.color[picture][channel];
          if (!counted.at(from)) half.counted.counts[to] = 0;
        }
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

void check(const ComparedImage& reference, const ComparedImage& test) {
  require_same_size(reference, test);
  for (const ComparedImage* const image : {&reference, &test})
    if (image->color_channels == 0)
      throw Error(
          {.file = image->file.string(), .problem = "SSIM needs colour", .expected = "channels R G B"});
}

double mean_of(const double (&channels)[3]) {
  return (channels[0] + channels[1] + channels[2]) / 3.0;
}

}  // namespace

Similarity similarity(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  check(reference, test);
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  const PairPixels pixels(reference, test, counted, ColorEncoding::display);
  Means means = Windows(pixels, reference.width, reference.height, counted).run();
  Similarity result{.ssim = mean_of(means.similarity)};
  if (std::min(reference.width, reference.height) < k_shortest_side) return result;

  constexpr double k_weights[k_scales] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  double products[3] = {1.0, 1.0, 1.0};
  HalfPictures half = halved(pixels, reference.width, reference.height, counted);
  for (int scale = 0; scale < k_scales; ++scale) {
    const bool is_last = scale == k_scales - 1;
    if (scale > 0) means = Windows(half, half.width, half.height, half.counted).run();
    if (scale > 0 && !is_last) half = halved(half, half.width, half.height, half.counted);
    for (int channel = 0; channel < 3; ++channel)
      products[channel] *=
          weighted(is_last ? means.similarity[channel] : means.contrast[channel], k_weights[scale]);
  }
  result.ms_ssim = mean_of(products);
  return result;
}

}  // namespace alidade
