// SPDX-License-Identifier: MIT
#include "visibility/sky/sky_of_cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "tests/visibility/sampled_shapes.h"
#include "visibility/raster/map_targets.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

/// A square with a wall along its north side.
Points yard() {
  Points points;
  add_rectangle(points, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 0.2);
  add_rectangle(points, {-5, 5, 0}, {10, 0, 0}, {0, 0, 4}, 0.2);
  return points;
}

/// Morning, noon, afternoon.
LightOf<SunHours> bins() {
  const std::vector<SunStep> steps{{90.0, 20.0, 1.0}, {180.0, 60.0, 2.0}, {330.0, 30.0, 4.0}};
  return sun_light(steps, 1, {});
}

HugeVector<float> point_hours(const Occluders& occluders, const LongWork& work = {}) {
  const LightOf<SunHours> light = bins();
  SunHoursMeasure measure(occluders, light, {});
  return point_sun(occluders, {}, measure, work);
}

HugeVector<float> ground_hours(const Occluders& occluders, const Ground& ground, const RasterGrid& grid) {
  const LightOf<SunHours> light = bins();
  SunHoursMeasure measure(occluders, light, {});
  return ground_sun(occluders, ground, grid, 0.0, measure);
}

TEST(PointSkyViews, are_those_of_single_targets_by_point_id) {
  const Points points = yard();
  const Occluders occluders(octree_of(points), {});
  const SkyViewOptions options{.directions = 16};
  const std::vector<float> views = point_sky_views(occluders, {}, options);
  ASSERT_EQ(views.size(), points.size());
  for (std::size_t id = 0; id < points.size(); id += 97) {
    const SkyTarget target = target_on_point(occluders, id, points[id], {});
    float view = 0.0f;
    sky_views(occluders, std::span(&target, 1), options, std::span(&view, 1));
    EXPECT_EQ(views[id], view) << id;
  }
}

TEST(PointSkyViews, use_valid_normals) {
  const Points points = yard();
  const Occluders occluders(octree_of(points), {});
  std::vector<glm::vec3> normals(points.size(), glm::vec3(0, 0, -1));
  normals[0] = glm::vec3(0.0f);
  normals[1] = glm::vec3(NAN, 0, 0);
  const std::vector<float> views = point_sky_views(occluders, normals, {.directions = 16});
  EXPECT_GT(views[0], 0.5f);
  EXPECT_GT(views[1], 0.5f);
  EXPECT_LT(views[2], 0.1f) << "it faces down";
  normals.pop_back();
  EXPECT_THROW(point_sky_views(occluders, normals, {}), Error);
}

TEST(PointSunHours, are_those_of_single_targets_by_point_id) {
  const Points points = yard();
  const Occluders occluders(octree_of(points), {});
  const HugeVector<float> hours = point_hours(occluders);
  ASSERT_EQ(hours.size(), points.size());
  for (std::size_t id = 0; id < points.size(); id += 97) {
    std::vector<SkyTarget> target{target_on_point(occluders, id, points[id], {})};
    find_open_sides(occluders, 64, target);
    float answer = 0.0f;
    sun_hours(occluders, target, bins(), {}, std::span(&answer, 1));
    EXPECT_EQ(hours[id], answer) << id;
  }
}

/// Runs work, stops it after half of its points, then resumes it.
template <class Work>
auto stopped_and_resumed(const Work& work) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "sky_of_cloud.state";
  std::filesystem::remove(file);
  const Fingerprint fingerprint{{"command", "sky"}};
  {
    PartCheckpoint parts({.file = file, .interval = 1e-3}, fingerprint);
    const Progress half = [](std::uint64_t done, std::uint64_t total) { return 2 * done < total; };
    EXPECT_THROW(work(LongWork{half, &parts}), Cancelled);
  }
  PartCheckpoint parts({.file = file, .resume = true}, fingerprint);
  EXPECT_GT(parts.finished(), 0u);
  EXPECT_LT(parts.finished(), parts.count());
  auto answers = work(LongWork{{}, &parts});
  parts.remove();
  return answers;
}

TEST(PointSkyViews, are_the_same_when_the_run_was_stopped_between) {
  Points points;
  add_rectangle(points, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 0.05);
  const Occluders occluders(octree_of(points), {.radius = 0.1});
  ASSERT_GT(points.size(), 35000u);
  const SkyViewOptions options{.directions = 3};
  EXPECT_EQ(stopped_and_resumed(
                [&](const LongWork& work) { return point_sky_views(occluders, {}, options, work); }),
            point_sky_views(occluders, {}, options));
  EXPECT_EQ(stopped_and_resumed([&](const LongWork& work) { return point_hours(occluders, work); }),
            point_hours(occluders));
}

TEST(GroundSkyViews, fall_towards_a_wall_and_are_nothing_without_ground) {
  const Points points = yard();
  const Octree octree = octree_of(points);
  const Occluders occluders(octree, {.radius = 0.2});
  const Ground ground = make_ground(octree, {}, {.cell_size = 0.5, .reach = 1.0});
  RasterGrid grid;
  grid.north_west = {-1.0, 4.5};
  grid.cell_size = 1.0;
  grid.columns = 2;
  grid.rows = 14;
  const Raster<float> views =
      ground_sky_views(occluders, ground, grid, 0.0, {.directions = 64, .receiver = SkyReceiver::horizontal});
  for (int row = 0; row + 1 < 9; ++row) EXPECT_LE(views.at(0, row), views.at(0, row + 1) + 0.02f) << row;
  EXPECT_LT(views.at(0, 0), 0.65f);
  EXPECT_GT(views.at(0, 8), 0.9f);
  EXPECT_TRUE(std::isnan(views.at(0, 13))) << "3 m south of the last point";
  const Raster<float> above = ground_sky_views(occluders, ground, grid, 4.5, {.directions = 64});
  EXPECT_GT(above.at(0, 0), 0.99f);
  EXPECT_THROW(ground_sky_views(occluders, ground, grid, -1.0, {}), Error);
}

TEST(GroundSkyViews, are_seen_from_the_positions_that_a_viewshed_looks_at) {
  const Occluders occluders(octree_of(yard()), {});
  const Ground ground = make_ground(occluders.octree(), {}, {.cell_size = 0.5, .reach = 1.0});
  const RasterGrid grid = grid_over({{-4, -4, 0}, {4, 4, 0}}, 1.0);
  const Raster<float> views = ground_sky_views(occluders, ground, grid, 0.25,
                                               {.directions = 32, .receiver = SkyReceiver::horizontal});
  for (int row = 0; row < grid.rows; ++row) {
    const glm::dvec2 position = grid.center(3, row);
    const SkyTarget target = target_in_open(
        raised(end_on_ground(occluders, {position.x, position.y, *ground.at(position)}), 0.25));
    float view = 0.0f;
    sky_views(occluders, {&target, 1}, {.directions = 32, .receiver = SkyReceiver::horizontal}, {&view, 1});
    EXPECT_EQ(views.at(3, row), view) << row;
  }
}

TEST(GroundSkyViews, of_more_cells_than_fit_into_the_memory_are_rejected_beforehand) {
  const Occluders occluders(octree_of(yard()), {});
  const Ground ground = make_ground(occluders.octree(), {}, {.cell_size = 0.5, .reach = 1.0});
  RasterGrid grid;
  grid.columns = 2'000'000'000;
  grid.rows = 1'000'000;
  EXPECT_THROW(ground_sky_views(occluders, ground, grid, 0.0, {}), Error);
  EXPECT_THROW(ground_hours(occluders, ground, grid), Error);
}

TEST(GroundSunHours, fall_in_the_shadow_of_a_wall) {
  const Octree octree = octree_of(yard());
  const Occluders occluders(octree, {.radius = 0.2});
  const Ground ground = make_ground(octree, {}, {.cell_size = 0.5, .reach = 1.0});
  RasterGrid grid;
  grid.north_west = {-1.0, 5.0};
  grid.cell_size = 2.0;
  grid.columns = 1;
  grid.rows = 8;
  const HugeVector<float> map = ground_hours(occluders, ground, grid);
  // The wall hides the sun in the north-west from positions nearer than 4 m / tan 30 degrees.
  EXPECT_NEAR(map[0], 3.0, 1e-6);
  EXPECT_NEAR(map[4], 7.0, 1e-6);
  EXPECT_TRUE(std::isnan(map[7]));
}

}  // namespace
}  // namespace alidade::test
