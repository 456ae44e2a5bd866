// SPDX-License-Identifier: MIT
// Elevation rasters that block lines of sight, alone and beside points and meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "octree/build.h"
#include "tests/visibility/checked_sight.h"
#include "tests/visibility/wall_cloud.h"
#include "visibility/horizon/horizon.h"
#include "visibility/lines/line_report.h"
#include "visibility/raster/curved_sight.h"
#include "visibility/raster/ground.h"
#include "visibility/sky/sky_view.h"

namespace alidade::test {

using namespace geo;

namespace {

constexpr float k_hole = std::numeric_limits<float>::quiet_NaN();

/// Flat ground at `ground`, 100 x 100 around the origin in cells of 1, with a ridge along x = 0.5 of this
/// height.
std::shared_ptr<const TerrainSurface> ridge(double height, double ground = 0.0) {
  Raster<float> heights({{-50, 50}, 1.0, 100, 100}, static_cast<float>(ground));
  for (int row = 0; row < 100; ++row) heights.at(50, row) = static_cast<float>(height);
  return std::make_shared<const TerrainSurface>(std::move(heights));
}

Occluders alone(std::shared_ptr<const TerrainSurface> terrain, int transparency = 1) {
  OccluderOptions options;
  options.transparency = transparency;
  options.terrain = std::move(terrain);
  return Occluders(build(PointCloud()), options);
}

TEST(SightTerrain, without_points_it_blocks_where_the_line_meets_it_whatever_the_transparency) {
  for (const int transparency : {1, 3}) {
    const Occluders occluders = alone(ridge(4.0), transparency);
    const auto blocker = blocker_of(occluders, sight_line({{-9.5, 0.2, 2}}, {{9.5, 0.2, 2}}));
    ASSERT_TRUE(blocker);
    EXPECT_TRUE(blocker->is_mesh());
    // The flank rises from x = -0.5 to 4 at 0.5.
    EXPECT_NEAR(blocker->distance, 9.5, 1e-9);
    EXPECT_NEAR(glm::distance(blocker->position, glm::dvec3(0.0, 0.2, 2.0)), 0.0, 1e-9);
    EXPECT_FALSE(blocker_of(occluders, sight_line({{-9.5, 0.2, 4.01}}, {{9.5, 0.2, 4.01}})));
    EXPECT_TRUE(blocker_of(occluders, sight_line({{3, 0, -1}}, {{3, 0, 1}}))) << "from below";
    EXPECT_TRUE(blocker_of(occluders, sight_ray({{3, 0, 1}}, {0, 0, -1})));
    EXPECT_FALSE(blocker_of(occluders, sight_ray({{3, 0, 1}}, {0, 0, -1}, 0.999)));
    EXPECT_FALSE(blocker_of(occluders, sight_ray({{70, 0, 1}}, {0, 0, -1}))) << "outside";
  }
}

TEST(SightTerrain, an_end_is_not_blocked_by_the_surface_it_lies_on_within_a_millimetre) {
  const Occluders occluders = alone(ridge(4.0));
  for (const double depth : {0.0, 0.0009, -0.0009}) {
    EXPECT_FALSE(blocker_of(occluders, sight_line({{-9, 0, 2}}, {{-3.2, 0.3, depth}}))) << depth;
    EXPECT_FALSE(blocker_of(occluders, sight_line({{-3.2, 0.3, depth}}, {{-9, 0, 2}}))) << depth;
    EXPECT_FALSE(blocker_of(occluders, sight_line({{-3.5, 0.5, depth}}, {{-9, 0, 0.5}}))) << "at a centre";
  }
  EXPECT_TRUE(blocker_of(occluders, sight_line({{-9, 0, 2}}, {{-3.2, 0.3, -0.0011}})));
  EXPECT_FALSE(blocker_of(occluders, sight_line({{-9, 0, 0}}, {{-3, 4, 0}}))) << "along flat ground";
  EXPECT_TRUE(blocker_of(occluders, sight_line({{-9, 0, 0}}, {{9, 0, 0}}))) << "through the ridge";
  EXPECT_FALSE(blocker_of(occluders, sight_line({{0.5, 0, 4}}, {{9, 0, 0}}))) << "from the ridge";
}

TEST(SightTerrain, a_line_from_the_surface_into_the_ground_is_blocked) {
  // A dome from edge to edge, and a slope.
  Raster<float> dome({{-50, 50}, 1.0, 100, 100}, 0.0f), slope = dome;
  for (int row = 0; row < 100; ++row) {
    for (int column = 0; column < 100; ++column) {
      const double x = column - 49.5, y = 49.5 - row;
      dome.at(column, row) = static_cast<float>(std::sqrt(10000.0 - x * x - y * y));
      slope.at(column, row) = static_cast<float>(0.5 * x);
    }
  }
  const Occluders over = alone(std::make_shared<const TerrainSurface>(dome)),
                  up = alone(std::make_shared<const TerrainSurface>(slope));
  const auto at = [&](double x, double y) { return SightEnd{{x, y, std::sqrt(10000.0 - x * x - y * y)}}; };
  EXPECT_TRUE(blocker_of(over, sight_line(at(-30.5, 0.5), at(30.5, 0.5))))
      << "its ends alone are on the surface";
  EXPECT_FALSE(blocker_of(over, sight_line(at(-30.5, 0.5), at(-29.5, 0.5))))
      << "between two neighbouring cells";
  for (const double depth : {0.0, 0.0009, -0.0009}) {
    const SightEnd foot{{0.25, 0.25, 0.125 - depth}};
    EXPECT_TRUE(blocker_of(up, sight_ray(foot, {1, 0, 0}))) << depth;
    EXPECT_TRUE(blocker_of(up, sight_ray(foot, {0.9, 0, 0.4}))) << depth;
    EXPECT_FALSE(blocker_of(up, sight_ray(foot, {0.8, 0, 0.45}))) << depth;
    EXPECT_FALSE(blocker_of(up, sight_ray(foot, {-1, 0, 0}))) << depth;
    EXPECT_FALSE(blocker_of(up, sight_ray(foot, {1, 0, 0.5}))) << depth << ": along the slope";
  }
}

TEST(SightTerrain, of_points_mesh_and_terrain_the_first_blocks) {
  WallCloud cloud;
  cloud.add({5, -2, 0}, {0, 4, 0}, {0, 0, 4}, 0.1);
  TriangleMesh triangle;
  triangle.vertices = {{-4, -2, 0}, {-4, 2, 0}, {-4, 0, 6}};
  triangle.triangles = {{0, 1, 2}};
  const auto mesh = std::make_shared<const TriangleTree>(triangle);
  const auto at = [&](OccluderOptions options, double from) {
    const auto blocker =
        blocker_of(cloud.occluders(options), sight_line({{from, 0.03, 2.02}}, {{9, 0.03, 2.02}}));
    return blocker ? std::round(100.0 * (blocker->distance + from)) / 100.0 : 99.0;
  };
  EXPECT_EQ(at({.mesh = mesh, .terrain = ridge(4.04)}, -9.0), -4.0);
  EXPECT_EQ(at({.mesh = mesh, .terrain = ridge(4.04)}, -3.0), 0.0);
  EXPECT_EQ(at({.terrain = ridge(4.04)}, -9.0), 0.0);
  EXPECT_EQ(at({.mesh = mesh, .terrain = ridge(1.0)}, -3.0), 5.0);
}

TEST(SightTerrain, bent_lines_meet_it_far_away) {
  // On a round Earth the middle of a line of 20 km hangs 7 m below its chord.
  const SightCurve curve(1.0, 1.0);
  const glm::dvec3 from(-10000, 0, 100), to(10000, 0, 100);
  const double low = curve.position(from, to, 0.500025).z;
  for (const double height : {low - 0.1, low + 0.1}) {
    SightBatch batch(alone(ridge(height)), curve);
    batch.add({from}, {to});
    EXPECT_EQ(batch.blocked()[0], height > low ? 1 : 0);
    const std::optional<Blocker> blocker = batch.first_blockers()[0];
    ASSERT_EQ(blocker.has_value(), height > low);
    if (blocker) {
      EXPECT_NEAR(blocker->distance, 10000.0, 1.0);
    }
  }
}

TEST(SightTerrain, horizon_sky_and_lines_need_no_points) {
  const Occluders occluders = alone(ridge(12.0));
  const SightEnd eye{{-9.5, 0, 2}};
  const std::vector<HorizonDirection> line =
      horizon(occluders, eye, {.step = 30.0, .azimuth_min = 90.0, .azimuth_max = 90.5});
  ASSERT_EQ(line.size(), 1u);
  ASSERT_TRUE(line[0].elevation);
  EXPECT_NEAR(*line[0].elevation, 45.0, 0.01) << "10 m higher and 10 m away";
  EXPECT_LT(sky_shares(occluders, {{0.5, 0, -1}}, 256).cosine_weighted, 0.01) << "below the ground";
  EXPECT_GT(sky_shares(occluders, {{0.5, 0, 12}}, 256).cosine_weighted, 0.99) << "on the ridge";
  const LinePair pairs[] = {{"a", eye, "b", {{9.5, 0, 2}}}, {"a", eye, "c", {{-2, 3, 1}}}};
  const std::vector<LineReport> reports = report_lines(occluders, pairs, {});
  ASSERT_TRUE(reports[0].blocker);
  EXPECT_TRUE(reports[0].blocker->is_mesh());
  EXPECT_FALSE(reports[1].blocker);
}

TEST(SightTerrain, its_ground_is_its_heights_and_that_of_points_is_raised_to_it) {
  Raster<float> heights({{0, 4}, 2.0, 3, 2}, 1.0f);
  heights.values = {1, 2, k_hole, 5, 6, 7};
  const TerrainSurface terrain(heights);
  const Ground ground(terrain);
  EXPECT_EQ(ground.source(), GroundSource::terrain);
  EXPECT_EQ(ground.measured_cells(), 5u);
  EXPECT_EQ(ground.at({1, 3}), 1.0);
  EXPECT_EQ(ground.at({2, 2}), 3.5);
  EXPECT_EQ(ground.at({0, 4}), 1.0) << "to the edge of the cell";
  EXPECT_FALSE(ground.at({-0.01, 3}));
  EXPECT_FALSE(ground.at({5, 3}));
  Raster<double> low({{0, 4}, 2.0, 1, 2}, 1.5);
  Ground points(low, 0.0, GroundSource::lowest, 2);
  points.raise_to(std::make_shared<const Ground>(terrain));
  EXPECT_EQ(points.at({1, 3}), 1.5);
  EXPECT_EQ(points.at({1, 1}), 5.0);
  EXPECT_EQ(points.at({3, 1}), 6.0) << "beyond the points";
  EXPECT_FALSE(points.at({9, 1}));
  EXPECT_THROW(make_ground(WallCloud().add({0, 0, 0}).octree(), {}, {.source = GroundSource::terrain}),
               Error);
}

}  // namespace
}  // namespace alidade::test
