// SPDX-License-Identifier: MIT
#include "renderer/image_state.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <numeric>

#include "base/morton.h"
#include "renderer/noise.h"

namespace alidade::renderer {
namespace {

double square_sum(const glm::vec3& v) {
  return static_cast<double>(v.x) * v.x + static_cast<double>(v.y) * v.y + static_cast<double>(v.z) * v.z;
}

/// First pixel of a tile's row in its band.
std::size_t band_index(const ImageState& state, const image::PixelBox& box, int y) {
  return static_cast<std::size_t>(y - box.top) * static_cast<std::size_t>(state.grid.width()) +
         static_cast<std::size_t>(box.left);
}

}  // namespace

std::vector<std::size_t> tiles_of(const TileGrid& grid, ImagePart part) {
  std::vector<std::size_t> order(grid.count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t tile) {
    return morton_key(static_cast<std::uint32_t>(grid.column_of(tile)),
                      static_cast<std::uint32_t>(grid.row_of(tile)), 0);
  });
  if (part.count == 1) return order;
  std::vector<std::size_t> tiles;
  for (auto i = static_cast<std::size_t>(part.number - 1); i < order.size();
       i += static_cast<std::size_t>(part.count))
    tiles.push_back(order[i]);
  return tiles;
}

ImageState::ImageState(int width, int height, bool noise, ImagePart part)
    : grid(width, height),
      order(tiles_of(grid, part)),
      with_noise(noise),
      bands(static_cast<std::size_t>(grid.rows())),
      tiles(grid.count()),
      levels(noise ? grid.count() : 0, LevelSums{}) {
  for (int row = 0; row < grid.rows(); ++row) {
    const std::size_t count = grid.band(row).count();
    SumBand& band = bands[static_cast<std::size_t>(row)];
    band.mean.assign(count, glm::dvec3(0.0));
    band.met_count.assign(count, 0);
    if (!noise) continue;
    band.squares.assign(count, glm::vec3(0.0f));
    band.earlier.assign(count, glm::vec3(0.0f));
  }
}

std::uint64_t ImageState::sample_count() const {
  std::uint64_t count = 0;
  for (std::size_t tile = 0; tile < tiles.size(); ++tile)
    count += std::uint64_t{tiles[tile].samples} * grid.box(tile).count();
  return count;
}

std::uint64_t ImageState::ray_count() const {
  std::uint64_t count = 0;
  for (const TileState& tile : tiles) count += tile.ray_count;
  return count;
}

void add_samples(ImageState& state, std::size_t tile, std::span<const PathResult> results) {
  const image::PixelBox box = state.grid.box(tile);
  assert(results.size() % box.count() == 0);
  TileState& reached = state.tiles[tile];
  SumBand& band = state.bands[static_cast<std::size_t>(state.grid.row_of(tile))];
  const std::uint32_t first = reached.samples,
                      last = first + static_cast<std::uint32_t>(results.size() / box.count());
  auto result = results.begin();
  for (int y = box.top; y < box.bottom; ++y) {
    const std::size_t row = band_index(state, box, y);
    for (std::size_t pixel = row; pixel < row + static_cast<std::size_t>(box.width()); ++pixel) {
      glm::dvec3& mean = band.mean[pixel];
      for (std::uint32_t count = first + 1; count <= last; ++count, ++result) {
        const glm::dvec3 value(result->radiance);
        const glm::dvec3 difference = value - mean;
        mean += difference / static_cast<double>(count);
        band.met_count[pixel] += result->met_surface ? 1 : 0;
        reached.ray_count += result->ray_count;
        if (!state.with_noise) continue;
        band.squares[pixel] += glm::vec3(difference * (value - mean));
        if (!std::has_single_bit(count)) continue;
        const glm::vec3 now(mean);
        if (count > 1) {
          const auto level = static_cast<std::size_t>(std::bit_width(count) - 2);
          state.levels[tile][level] += square_sum(now - band.earlier[pixel]);
        }
        band.earlier[pixel] = now;
      }
    }
  }
  reached.samples = last;
}

image::Film reduced(const ImageState& state, int longest_side) {
  const int width = state.grid.width(), height = state.grid.height();
  const int factor = (std::max(width, height) + longest_side - 1) / longest_side;
  constexpr image::Layer k_color[] = {image::Layer::color};
  image::Film film((width + factor - 1) / factor, (height + factor - 1) / factor, k_color);
  std::vector<std::uint32_t> counts(film.count());
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    const std::uint32_t samples = state.tiles[tile].samples;
    if (samples == 0) continue;
    const image::PixelBox box = state.grid.box(tile);
    const SumBand& band = state.bands[static_cast<std::size_t>(state.grid.row_of(tile))];
    for (int y = box.top; y < box.bottom; ++y) {
      std::size_t pixel = band_index(state, box, y);
      for (int x = box.left; x < box.right; ++x, ++pixel) {
        const std::size_t to = film.index(x / factor, y / factor);
        film.color[to] += Rgb(band.mean[pixel]);
        film.alpha[to] += static_cast<float>(band.met_count[pixel]) / static_cast<float>(samples);
        ++counts[to];
      }
    }
  }
  for (std::size_t pixel = 0; pixel < counts.size(); ++pixel) {
    if (counts[pixel] == 0) continue;
    film.color[pixel] /= static_cast<float>(counts[pixel]);
    film.alpha[pixel] /= static_cast<float>(counts[pixel]);
  }
  return film;
}

void move_into_film(ImageState& state, bool with_variance, image::Film& film) {
  constexpr Rgb k_unknown(std::numeric_limits<float>::infinity());
  film.color.reserve(film.count());
  film.alpha.reserve(film.count());
  if (with_variance) film.variance.reserve(film.count());
  std::vector<double> variance_scale(static_cast<std::size_t>(state.grid.columns()));
  for (int row = 0; row < state.grid.rows(); ++row) {
    SumBand& band = state.bands[static_cast<std::size_t>(row)];
    const std::size_t first_tile = state.grid.tile_at(0, row);
    for (std::size_t column = 0; with_variance && column < variance_scale.size(); ++column) {
      const std::size_t tile = first_tile + column;
      const std::uint32_t samples = state.tiles[tile].samples;
      if (samples >= 2) variance_scale[column] = mean_variance_scale(state.levels[tile], samples);
    }
    const image::PixelBox pixels = state.grid.band(row);
    std::size_t pixel = 0;
    for (int y = pixels.top; y < pixels.bottom; ++y) {
      for (int column = 0; column < state.grid.columns(); ++column) {
        const std::size_t tile = state.grid.tile_at(column, row);
        const auto samples = static_cast<float>(state.tiles[tile].samples);
        const int width = state.grid.box(tile).width();
        for (int i = 0; i < width; ++i, ++pixel) {
          film.color.push_back(Rgb(band.mean[pixel]));
          film.alpha.push_back(samples > 0.0f ? static_cast<float>(band.met_count[pixel]) / samples : 0.0f);
          if (!with_variance) continue;
          film.variance.push_back(samples < 2.0f ? k_unknown
                                                 : Rgb(glm::dvec3(band.squares[pixel]) *
                                                       variance_scale[static_cast<std::size_t>(column)]));
        }
      }
    }
    band = SumBand();
  }
}

}  // namespace alidade::renderer
