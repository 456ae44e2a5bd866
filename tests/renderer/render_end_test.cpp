// SPDX-License-Identifier: MIT
// When a render ends, and what one sees of it before.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "renderer/noise.h"
#include "tests/renderer/mixed_scene.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

using test::expect_same;
using test::mixed_cloud;
using test::mixed_scene;

TEST(TargetNoise, film_does_not_depend_on_the_number_of_threads) {
  const LoadedCloud cloud = mixed_cloud();
  Scene scene = mixed_scene();
  scene.render.samples = 96;
  Film films[3];
  RenderStatistics statistics[3];
  for (int threads = 1; threads <= 3; ++threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    films[threads - 1] = render(scene, &cloud, {.target_noise = 0.08}, &statistics[threads - 1]);
  }
  expect_same(films[0], films[1]);
  expect_same(films[0], films[2]);
  EXPECT_EQ(statistics[0].ray_count, statistics[1].ray_count);
  // The target is one that parts the tiles.
  EXPECT_EQ(statistics[0].least_samples, 32);
  EXPECT_GT(statistics[0].most_samples, 32);
}

TEST(TargetNoise, is_reached_by_every_tile_that_stopped_before_the_last_sample) {
  Scene scene = mixed_scene();
  scene.render.samples = 4096;
  RenderStatistics statistics;
  render(scene, nullptr, {.target_noise = 0.1}, &statistics);
  ASSERT_TRUE(statistics.noise);
  EXPECT_LT(statistics.most_samples, 4096);
  EXPECT_LE(statistics.noise->worst, 0.1);
  EXPECT_EQ(statistics.noisy_tiles, 0u);
  EXPECT_LE(statistics.noise->median, statistics.noise->worst);
  EXPECT_GE(statistics.least_samples, 32);
  EXPECT_GE(statistics.mean_samples, statistics.least_samples);
  EXPECT_LE(statistics.mean_samples, statistics.most_samples);
}

TEST(TargetNoise, that_cannot_be_reached_takes_all_samples) {
  const Scene scene = mixed_scene();
  RenderStatistics statistics;
  const Film film = render(scene, nullptr, {.target_noise = 1e-9}, &statistics);
  expect_same(film, render(scene, nullptr));
  EXPECT_EQ(statistics.least_samples, scene.render.samples);
  EXPECT_GT(statistics.tiles, 1u);
  EXPECT_EQ(statistics.noisy_tiles, statistics.tiles);
  EXPECT_EQ(statistics.hurried_tiles, 0u);
}

TEST(TargetNoise, of_an_image_without_noise_takes_32_samples) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0}, {0, 1, 0}, 30.0, 40), 1000, 2);
  scene.sky = ConstantSky{Rgb(0.5f)};
  RenderStatistics statistics;
  render(scene, nullptr, {.target_noise = 0.01}, &statistics);
  EXPECT_EQ(statistics.most_samples, 32);
  EXPECT_EQ(statistics.noise->worst, 0.0);
}

TEST(TargetNoise, waits_for_the_neighbours_together) {
  // Three tiles in a row; the left one is calm, the middle one calm enough alone, the right one not at all.
  ImageState state(48, 16, true);
  ASSERT_EQ(state.tiles.size(), 3u);
  for (std::size_t tile = 0; tile < 3; ++tile) {
    std::vector<PathResult> results;
    for (std::size_t pixel = 0; pixel < state.grid.box(tile).count(); ++pixel) {
      // Half of the pixels begin dark and half bright, so that noise falls as for independent samples.
      for (std::uint32_t i = 0; i < 32; ++i) {
        const bool bright = (i * 2654435761u + pixel * 40503u) >> 7 & 1u;
        const float swing = tile == 0 ? 0.0f : tile == 1 ? 0.1f : 5.0f;
        results.push_back({Rgb(6.0f + (bright ? swing : -swing)), true, 1});
      }
    }
    add_samples(state, tile, results);
  }
  const double middle = tile_noise(state, 1).error(0.0), right = tile_noise(state, 2).error(0.0);
  ASSERT_LT(middle, 0.2 * right);
  StopRule rule(0.5 * right, 0.0);
  rule.apply(state);
  EXPECT_TRUE(state.tiles[0].stopped);
  EXPECT_FALSE(state.tiles[2].stopped);
  // Together with the right one the middle one has 1 / sqrt(3) of its error.
  EXPECT_FALSE(state.tiles[1].stopped);
  EXPECT_EQ(rule.expected_samples(state, 0, 1000), 32);
  EXPECT_NEAR(rule.expected_samples(state, 2, 1000), 128, 1e-6);
}

TEST(TimeLimit, of_no_time_takes_one_sample_of_every_pixel) {
  Scene scene = mixed_scene();
  scene.render.samples = 64;
  const LoadedCloud cloud = mixed_cloud();
  RenderStatistics statistics;
  const Film film = render(scene, &cloud, {.time_limit = 0.0}, &statistics);
  EXPECT_EQ(statistics.least_samples, 1);
  EXPECT_EQ(statistics.most_samples, 1);
  EXPECT_EQ(statistics.hurried_tiles, statistics.tiles);
  EXPECT_EQ(statistics.noisy_tiles, 0u);
  scene.render.samples = 1;
  expect_same(film, render(scene, &cloud));
}

TEST(TimeLimit, that_is_not_reached_changes_nothing) {
  const LoadedCloud cloud = mixed_cloud();
  RenderStatistics statistics;
  expect_same(render(mixed_scene(), &cloud, {.time_limit = 1e6}, &statistics), render(mixed_scene(), &cloud));
  EXPECT_EQ(statistics.least_samples, 5);
}

TEST(TimeLimit, ends_with_samples_spread_evenly) {
  Scene scene = mixed_scene();
  scene.render.samples = k_max_samples;
  RenderStatistics statistics;
  std::uint64_t done = 0, total = 0;
  RenderOptions options{.time_limit = 0.3};
  options.progress = [&](std::uint64_t now, std::uint64_t all) {
    EXPECT_LE(now, all);
    done = now;
    total = all;
    return true;
  };
  const Film film = render(scene, nullptr, options, &statistics);
  EXPECT_EQ(film.color.size(), film.count());
  EXPECT_GE(statistics.least_samples, 1);
  EXPECT_LE(statistics.most_samples, std::max(2 * statistics.least_samples, statistics.least_samples + 16));
  EXPECT_EQ(done, total);
  EXPECT_NEAR(static_cast<double>(done), statistics.mean_samples * static_cast<double>(film.count()), 1.0);
}

TEST(Preview, comes_after_the_first_sample_of_every_pixel_and_at_the_end) {
  const LoadedCloud cloud = mixed_cloud();
  std::vector<Film> previews;
  RenderOptions options;
  options.preview = {.show = [&](const Film& film) { previews.push_back(film); }, .interval = 1e6};
  const Film film = render(mixed_scene(), &cloud, options);
  ASSERT_EQ(previews.size(), 2u);
  EXPECT_EQ(previews.back().color, film.color);
  EXPECT_EQ(previews.back().alpha, film.alpha);
  Scene single = mixed_scene();
  single.render.samples = 1;
  EXPECT_EQ(previews.front().color, render(single, &cloud).color);
  expect_same(film, render(mixed_scene(), &cloud));
}

TEST(Preview, comes_again_and_again_and_is_small) {
  Scene scene = mixed_scene();
  scene.render.samples = 40;
  int count = 0;
  RenderOptions options;
  options.preview = {.show =
                         [&](const Film& film) {
                           ++count;
                           EXPECT_EQ(film.width, 35);
                           EXPECT_EQ(film.height, 25);
                           EXPECT_TRUE(film.depth.empty());
                         },
                     .interval = 0.0,
                     .longest_side = 69};
  render(scene, nullptr, options);
  EXPECT_GT(count, 2);
}

TEST(RenderOptions, outside_their_ranges_are_errors) {
  const Scene scene = mixed_scene();
  EXPECT_THROW(render(scene, nullptr, {.time_limit = -1.0}), Error);
  EXPECT_THROW(render(scene, nullptr, {.time_limit = NAN}), Error);
  EXPECT_THROW(render(scene, nullptr, {.target_noise = 0.0}), Error);
  EXPECT_THROW(render(scene, nullptr, {.target_noise = NAN}), Error);
  EXPECT_THROW(render(scene, nullptr, {.preview = PreviewOptions{.show = {}, .interval = -1.0}}), Error);
  EXPECT_THROW(render(scene, nullptr, {.checkpoint = CheckpointOptions{.file = "x", .interval = 0.0}}),
               Error);
}

}  // namespace
}  // namespace alidade
