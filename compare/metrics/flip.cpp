// SPDX-License-Identifier: MIT
#include "compare/metrics/flip.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <mutex>

#include "base/parallel.h"
#include "compare/metrics/flip_tile.h"
#include "compare/metrics/pixel_sums.h"

namespace alidade::compare {
namespace {

// A tile with all its planes stays in the cache of a core.
constexpr int k_tile_width = 256, k_tile_height = 96;

/// Reads a tile and what surrounds it; beyond the image its outermost pixels.
void load(FlipTile& tile, const PairPixels& pixels, int left, int top, int width, int height) {
  const int columns = tile.width() + 2 * tile.margin();
  for (int row = 0; row < tile.rows_with_margin(); ++row) {
    const int y = std::clamp(top - tile.margin() + row, 0, height - 1);
    const std::size_t line = tile.pitch() * static_cast<std::size_t>(row);
    for (int column = 0; column < columns; ++column) {
      const int x = std::clamp(left - tile.margin() + column, 0, width - 1);
      const auto pair = pixels.at(pixel_index(x, y, width));
      for (int image = 0; image < 2; ++image)
        for (int channel = 0; channel < 3; ++channel)
          tile.rgb(image, channel)[line + static_cast<std::size_t>(column)] = pair.color[image][channel];
    }
  }
}

/// Makes the map, tile by tile.
std::vector<float> flip_map(const ComparedImage& reference, const ComparedImage& test,
                            const ImageMask& counted, const std::vector<ToneCurve>& curves,
                            const FlipOptions& options, const Progress& progress) {
  const FlipFilters filters = flip_filters(options.pixels_per_degree);
  const simd::FlipKernel& kernel = simd::flip_kernel(usable(options.instruction_set));
  const PairPixels pixels(reference, test, counted, ColorEncoding::linear);
  const int width = reference.width, height = reference.height;
  const int tiles_across = (width + k_tile_width - 1) / k_tile_width;
  const int tiles = tiles_across * ((height + k_tile_height - 1) / k_tile_height);

  std::vector<float> map(reference.pixels());
  tbb::enumerable_thread_specific<FlipTile> rooms([&] {
    return FlipTile(std::min(k_tile_width, width), std::min(k_tile_height, height), filters.radius);
  });
  std::mutex mutex;
  int done = 0;
  in_parallel(tiles, 1, [&](int i) {
    FlipTile& tile = rooms.local();
    const int left = i % tiles_across * k_tile_width, top = i / tiles_across * k_tile_height;
    tile.begin(std::min(k_tile_width, width - left), std::min(k_tile_height, height - top));
    load(tile, pixels, left, top, width, height);
    for (const ToneCurve& curve : curves) kernel.add_exposure(tile, filters, curve);
    for (int y = 0; y < tile.height(); ++y) {
      const std::size_t first = pixel_index(left, top + y, width);
      const float* const row = tile.map() + tile.pitch() * static_cast<std::size_t>(y);
      for (std::size_t x = 0; x < static_cast<std::size_t>(tile.width()); ++x)
        map[first + x] = counted.at(first + x) ? row[x] : 0.0f;
    }
    const std::scoped_lock lock(mutex);
    report(progress, static_cast<std::uint64_t>(++done), static_cast<std::uint64_t>(tiles));
  });
  return map;
}

void pool(FlipResult& result, const ImageMask& counted, int width) {
  const std::size_t pixels = result.map.size(), columns = static_cast<std::size_t>(width);
  const std::uint64_t count = counted_pixels(counted, pixels);
  if (count == 0) return;
  double sum = 0.0;
  result.min = 1.0;
  for (std::size_t row = 0; row < pixels; row += columns) {
    double row_sum = 0.0;
    for (std::size_t pixel = row; pixel < row + columns; ++pixel) {
      const double value = result.map[pixel];
      row_sum += value;
      result.max = std::max(result.max, value);
      if (counted.at(pixel)) result.min = std::min(result.min, value);
    }
    sum += row_sum;
  }
  result.mean = sum / static_cast<double>(count);
  // Zeros have no weight, so excluded pixels need not be left out.
  const auto value_at = [&](std::size_t pixel) { return result.map[pixel]; };
  const FloatCounts counts = count_upper_halves(pixels, value_at);
  const auto quantile = [&](double share) { return weighted_rank(pixels, value_at, counts, share); };
  result.weighted_first_quartile = quantile(0.25);
  result.weighted_median = quantile(0.5);
  result.weighted_third_quartile = quantile(0.75);
}

}  // namespace

FlipResult flip(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                const FlipOptions& options, const Progress& progress) {
  require_colors(reference, test, "FLIP requires colours");
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  FlipResult result;
  std::vector<ToneCurve> curves{ToneCurve{}};
  const bool is_high = options.range == FlipRange::automatic ? reference.encoding == ColorEncoding::linear
                                                             : options.range == FlipRange::high;
  if (is_high) {
    const ExposureRange range = exposure_range(reference, test, counted, options);
    result.start_exposure = range.start;
    result.stop_exposure = range.stop;
    result.exposures = range.count;
    curves.clear();
    for (int i = 0; i < range.count; ++i)
      curves.push_back(tone_curve(options.tone_mapper, range.exposure(i)));
  }
  result.map = flip_map(reference, test, counted, curves, options, progress);
  pool(result, counted, reference.width);
  return result;
}

}  // namespace alidade::compare
