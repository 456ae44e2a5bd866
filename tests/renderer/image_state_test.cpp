// SPDX-License-Identifier: MIT
#include "renderer/image_state.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/random.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

TEST(TileGrid, tiles_cover_every_pixel_once_and_none_is_a_sliver) {
  for (const int width : {1, 2, 11, 12, 15, 16, 17, 23, 24, 25, 39, 40, 600, 601}) {
    for (const int height : {1, 13, 31, 33, 400}) {
      const TileGrid grid(width, height);
      std::set<std::pair<int, int>> seen;
      std::size_t pixels = 0;
      for (std::size_t tile = 0; tile < grid.count(); ++tile) {
        const image::PixelBox box = grid.box(tile);
        EXPECT_GE(box.width(), std::min(width, 12));
        EXPECT_LE(box.width(), 23);
        EXPECT_GE(box.height(), std::min(height, 12));
        EXPECT_LE(box.height(), 23);
        EXPECT_EQ(grid.tile_at(grid.column_of(tile), grid.row_of(tile)), tile);
        EXPECT_EQ(grid.band(grid.row_of(tile)).top, box.top);
        EXPECT_EQ(grid.band(grid.row_of(tile)).bottom, box.bottom);
        pixels += box.count();
        for (int y = box.top; y < box.bottom; ++y)
          for (int x = box.left; x < box.right; ++x) seen.emplace(x, y);
      }
      EXPECT_EQ(pixels, static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      EXPECT_EQ(seen.size(), pixels);
      EXPECT_EQ(seen.rbegin()->first, width - 1);
    }
  }
}

/// `samples` results for each of a tile's pixels.
std::vector<PathResult> random_results(std::size_t pixels, std::uint32_t samples, test::Random& random) {
  std::vector<PathResult> results(pixels * samples);
  for (PathResult& result : results) {
    result.radiance = Rgb(random.in_cube() + 1.0);
    result.met_surface = random.unit() < 0.3;
    result.ray_count = random.below(5);
  }
  return results;
}

/// The samples [first, last) of each pixel.
std::vector<PathResult> part(const std::vector<PathResult>& results, std::size_t pixels, std::uint32_t first,
                             std::uint32_t last) {
  const std::size_t samples = results.size() / pixels;
  std::vector<PathResult> chosen;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (std::size_t i = first; i < last; ++i) chosen.push_back(results[pixel * samples + i]);
  return chosen;
}

TEST(ImageState, sums_do_not_depend_on_how_samples_are_dealt_out) {
  test::Random random;
  ImageState at_once(40, 30, true), in_parts(40, 30, true);
  for (std::size_t tile = 0; tile < at_once.tiles.size(); ++tile) {
    const std::size_t pixels = at_once.grid.box(tile).count();
    const std::vector<PathResult> results = random_results(pixels, 37, random);
    add_samples(at_once, tile, results);
    std::uint32_t done = 0;
    while (done < 37) {
      const std::uint32_t next =
          std::min<std::uint32_t>(37, done + 1 + static_cast<std::uint32_t>(random.below(12)));
      add_samples(in_parts, tile, part(results, pixels, done, next));
      done = next;
    }
  }
  EXPECT_EQ(at_once.levels, in_parts.levels);
  EXPECT_EQ(at_once.ray_count(), in_parts.ray_count());
  EXPECT_EQ(at_once.sample_count(), 40u * 30 * 37);
  EXPECT_EQ(in_parts.sample_count(), 40u * 30 * 37);
  for (std::size_t row = 0; row < at_once.bands.size(); ++row) {
    EXPECT_EQ(at_once.bands[row].mean, in_parts.bands[row].mean);
    EXPECT_EQ(at_once.bands[row].squares, in_parts.bands[row].squares);
    EXPECT_EQ(at_once.bands[row].earlier, in_parts.bands[row].earlier);
    EXPECT_EQ(at_once.bands[row].met_count, in_parts.bands[row].met_count);
  }
}

TEST(ImageState, takes_28_bytes_per_pixel_and_52_with_noise) {
  for (const bool with_noise : {false, true}) {
    const ImageState state(1000, 500, with_noise);
    std::size_t bytes = 0;
    for (const SumBand& band : state.bands) {
      bytes += band.mean.capacity() * sizeof(glm::dvec3) + band.met_count.capacity() * sizeof(std::uint32_t) +
               (band.squares.capacity() + band.earlier.capacity()) * sizeof(glm::vec3);
    }
    EXPECT_EQ(bytes, 500'000u * (with_noise ? 52 : 28));
    const std::size_t of_tiles =
        state.tiles.capacity() * sizeof(TileState) + state.levels.capacity() * sizeof(LevelSums);
    EXPECT_LE(of_tiles, 500'000u);
  }
}

TEST(ImageState, becomes_a_film_with_the_mean_of_each_pixel) {
  test::Random random;
  ImageState state(40, 30, true);
  Film expected(40, 30);
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    const image::PixelBox box = state.grid.box(tile);
    const std::vector<PathResult> results = random_results(box.count(), 4, random);
    add_samples(state, tile, results);
    auto result = results.begin();
    for (int y = box.top; y < box.bottom; ++y) {
      for (int x = box.left; x < box.right; ++x) {
        for (int i = 0; i < 4; ++i, ++result) {
          expected.color[expected.index(x, y)] += result->radiance / 4.0f;
          expected.alpha[expected.index(x, y)] += result->met_surface ? 0.25f : 0.0f;
        }
      }
    }
  }
  constexpr Layer k_id[] = {Layer::id};
  Film film(40, 30, k_id);
  move_into_film(state, true, film);
  ASSERT_EQ(film.color.size(), expected.color.size());
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel) {
    EXPECT_NEAR(glm::distance(film.color[pixel], expected.color[pixel]), 0.0f, 1e-5f);
    EXPECT_EQ(film.alpha[pixel], expected.alpha[pixel]);
    EXPECT_GT(film.variance[pixel].r, 0.0f);
  }
  EXPECT_TRUE(state.bands.front().mean.empty());
}

TEST(ImageState, preview_is_the_mean_of_squares_of_pixels) {
  ImageState state(50, 20, false);
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    const image::PixelBox box = state.grid.box(tile);
    std::vector<PathResult> results;
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x)
        results.push_back({Rgb(static_cast<float>(x), static_cast<float>(y), 1.0f), x < 25, 1});
    add_samples(state, tile, results);
  }
  const Film same = reduced(state, 50);
  EXPECT_EQ(same.width, 50);
  EXPECT_EQ(same.height, 20);
  EXPECT_EQ(same.color[same.index(49, 19)], Rgb(49, 19, 1));
  // 20 pixels require squares of 3: 17 x 7, the last ones narrower.
  const Film small = reduced(state, 20);
  EXPECT_EQ(small.width, 17);
  EXPECT_EQ(small.height, 7);
  EXPECT_EQ(small.color[small.index(0, 0)], Rgb(1, 1, 1));
  EXPECT_EQ(small.color[small.index(5, 2)], Rgb(16, 7, 1));
  EXPECT_EQ(small.color[small.index(16, 6)], Rgb(48.5f, 18.5f, 1));
  EXPECT_NEAR(small.alpha[small.index(8, 0)], 1.0f / 3, 1e-6f);
  EXPECT_EQ(reduced(state, 1).color.size(), 1u);
}

}  // namespace
}  // namespace alidade
