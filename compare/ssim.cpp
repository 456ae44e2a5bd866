// SPDX-License-Identifier: MIT
#include "compare/ssim.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "compare/logarithm.h"
#include "compare/pair_pixels.h"
#include "compare/ssim_tile.h"

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

/// The picture continues as its mirror image.
int mirrored(int place, int size) {
  while (place < 0 || place >= size) place = place < 0 ? -1 - place : 2 * size - 1 - place;
  return place;
}

/// The similarity of the pictures that `pixels` has, pair by pair.
template <class Pixels>
class Comparison {
 public:
  Comparison(const Pixels& pixels, int width, int height, const ImageMask& counted, std::vector<float>* map)
      : pixels_(pixels), width_(width), height_(height), counted_(counted), map_(map) {}

  /// NaN without a window that counts.
  Means run() {
    const int across = (width_ + SsimTile::k_most_width - 1) / SsimTile::k_most_width;
    const int tiles = across * ((height_ + SsimTile::k_most_height - 1) / SsimTile::k_most_height);
    if (map_) map_->assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0.0f);
    std::vector<Sums> sums(static_cast<std::size_t>(tiles));
    tbb::enumerable_thread_specific<SsimTile> rooms;
    tbb::parallel_for(tbb::blocked_range<int>(0, tiles, 1), [&](const auto& range) {
      SsimTile& tile = rooms.local();
      for (int i = range.begin(); i != range.end(); ++i) {
        const int left = i % across * SsimTile::k_most_width, top = i / across * SsimTile::k_most_height;
        tile.begin(std::min(SsimTile::k_most_width, width_ - left),
                   std::min(SsimTile::k_most_height, height_ - top));
        for (int channel = 0; channel < 3; ++channel)
          add_channel(tile, left, top, channel, sums[static_cast<std::size_t>(i)]);
      }
    });
    return means(sums);
  }

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  void add_channel(SsimTile& tile, int left, int top, int channel, Sums& sums) {
    for (int row = 0; row < tile.rows_with_margin(); ++row) {
      const int y = mirrored(top + row - k_ssim_reach, height_);
      for (int column = 0; column < tile.columns_with_margin(); ++column) {
        const auto pair = pixels_.at(at(mirrored(left + column - k_ssim_reach, width_), y));
        tile.values(0, row)[column] = pair.color[0][channel];
        tile.values(1, row)[column] = pair.color[1][channel];
      }
    }
    tile.filter_rows();
    double similarity[SsimTile::k_most_width], contrast[SsimTile::k_most_width];
    for (int row = 0; row < tile.height(); ++row) {
      tile.similarities(row, similarity, contrast);
      const int y = top + row;
      for (int column = 0; column < tile.width(); ++column) {
        const int x = left + column;
        if (map_) (*map_)[at(x, y)] += static_cast<float>(similarity[column]) * (1.0f / 3.0f);
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
  std::vector<float>* const map_;
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

}  // namespace

SimilarityMap ssim(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  check(reference, test);
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  const PairPixels pixels(reference, test, counted, ColorEncoding::display);
  SimilarityMap result;
  const Means means = Comparison(pixels, reference.width, reference.height, counted, &result.map).run();
  result.mean = (means.similarity[0] + means.similarity[1] + means.similarity[2]) / 3.0;
  return result;
}

SimilarityMap ms_ssim(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  check(reference, test);
  if (std::min(reference.width, reference.height) < k_shortest_side)
    return {.mean = std::numeric_limits<double>::quiet_NaN(), .map = {}};
  constexpr double k_weights[k_scales] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  const PairPixels pixels(reference, test, counted, ColorEncoding::display);
  double products[3] = {1.0, 1.0, 1.0};
  HalfPictures half;
  for (int scale = 0; scale < k_scales; ++scale) {
    const bool is_whole = scale == 0, is_last = scale == k_scales - 1;
    const Means means = is_whole
                            ? Comparison(pixels, reference.width, reference.height, counted, nullptr).run()
                            : Comparison(half, half.width, half.height, half.counted, nullptr).run();
    for (int channel = 0; channel < 3; ++channel)
      products[channel] *=
          weighted(is_last ? means.similarity[channel] : means.contrast[channel], k_weights[scale]);
    if (is_last) break;
    half = is_whole ? halved(pixels, reference.width, reference.height, counted)
                    : halved(half, half.width, half.height, half.counted);
  }
  return {.mean = (products[0] + products[1] + products[2]) / 3.0, .map = {}};
}

}  // namespace alidade
