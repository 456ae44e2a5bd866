// SPDX-License-Identifier: MIT
#include "renderer/merge_parts.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "tests/renderer/mixed_scene.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

using test::expect_same;
using test::mixed_cloud;
using test::mixed_scene;

TEST(ImageParts, have_every_tile_once_and_differ_by_one_tile_at_most) {
  for (const auto& [width, height] : {std::pair{640, 400}, {16, 16}, {1000, 17}}) {
    const TileGrid grid(width, height);
    for (const int count : {1, 2, 3, 20, 64}) {
      std::vector<std::size_t> all;
      std::uint64_t pixels = 0;
      for (int number = 1; number <= count; ++number) {
        const std::vector<std::size_t> tiles = tiles_of(grid, {number, count});
        EXPECT_LE(tiles.size(), grid.count() / static_cast<std::size_t>(count) + 1);
        EXPECT_GE(tiles.size(), grid.count() / static_cast<std::size_t>(count));
        all.insert(all.end(), tiles.begin(), tiles.end());
        pixels += pixel_count(width, height, {number, count});
      }
      std::ranges::sort(all);
      EXPECT_EQ(all.size(), grid.count());
      EXPECT_EQ(std::ranges::adjacent_find(all), all.end());
      EXPECT_EQ(pixels, static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
    }
  }
}

TEST(ImageParts, are_spread_over_rows_and_columns) {
  const TileGrid grid(640, 640);
  ASSERT_EQ(grid.columns(), 40);
  // Every 20th tile of each row would be 2 of 40 columns.
  for (int number = 1; number <= 20; ++number) {
    std::set<int> columns, rows;
    for (const std::size_t tile : tiles_of(grid, {number, 20})) {
      columns.insert(grid.column_of(tile));
      rows.insert(grid.row_of(tile));
    }
    EXPECT_GE(columns.size(), 15u) << number;
    EXPECT_GE(rows.size(), 15u) << number;
  }
}

TEST(ImageParts, reject_invalid_numbers_and_ends_that_depend_on_other_parts) {
  const Scene scene = mixed_scene();
  for (const ImagePart part : {ImagePart{0, 2}, {3, 2}, {1, 0}, {-1, -1}, {1, k_most_parts + 1}})
    EXPECT_THROW(render(scene, nullptr, {.part = part}), Error) << part_text(part);
  EXPECT_THROW(render(scene, nullptr, {.time_limit = 5.0, .part = {1, 2}}), Error);
  EXPECT_THROW(render(scene, nullptr, {.target_noise = 0.1, .part = {1, 2}}), Error);
}

void expect_film_and_facts_of_one_run(PointShape shape) {
  SCOPED_TRACE(test::shape_name(shape));
  const auto folder = std::filesystem::temp_directory_path() / "alidade_merge_parts";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const LoadedCloud cloud = mixed_cloud(shape);
  const Scene scene = mixed_scene(shape);
  const OutputSettings output{.file = "a.exr", .layers = all_layers(), .exposure = 0.1, .half = false};
  ImageMetadata metadata;
  metadata.camera = *scene.camera;
  metadata.crs = {.wkt = "LOCAL[\"x\"]",
                  .geotiff_keys = {1, 1, 0, 65535},
                  .geotiff_doubles = {0.1, -1e300},
                  .geotiff_ascii = "WGS 84|"};
  metadata.further = {{"alidade:sun", "line 1\nline 2"}};
  std::vector<std::filesystem::path> files;
  RenderStatistics whole_statistics;
  const Film whole = render(scene, &cloud, {}, &whole_statistics);
  std::uint64_t rays = 0;
  for (int number = 1; number <= 3; ++number) {
    files.push_back(folder / std::to_string(number));
    RenderStatistics statistics;
    render_part(scene, &cloud, {.part = {number, 3}}, {files.back(), false, image_entries(output, metadata)},
                &statistics);
    EXPECT_EQ(statistics.least_samples, scene.render.samples);
    EXPECT_EQ(statistics.mean_samples, scene.render.samples);
    rays += statistics.ray_count;
  }
  EXPECT_EQ(rays, whole_statistics.ray_count);
  EXPECT_THROW(render_part(scene, &cloud, {.part = {1, 3}}, {files.front(), false, {}}), Error);
  const MergedImage merged = merge_parts(files, "b.exr");
  expect_same(merged.film, whole);
  EXPECT_EQ(merged.samples_taken, whole.count() * static_cast<std::uint64_t>(scene.render.samples));
  EXPECT_EQ(merged.output.layers, output.layers);
  EXPECT_EQ(merged.output.exposure, output.exposure);
  EXPECT_EQ(merged.output.half, output.half);
  const ImageFacts facts = image_facts(metadata, output);
  EXPECT_EQ(merged.facts.texts, facts.texts);
  EXPECT_EQ(merged.facts.crs, facts.crs);
  EXPECT_EQ(merged.facts.position_offset, facts.position_offset);
  std::filesystem::remove_all(folder);
}

TEST(MergeParts, gives_film_and_facts_of_one_run) {
  for (const PointShape shape : test::k_point_shapes) expect_film_and_facts_of_one_run(shape);
}

}  // namespace
}  // namespace alidade
