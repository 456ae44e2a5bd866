// SPDX-License-Identifier: MIT
#include "geo/terrain_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/support/random.h"

namespace alidade::test {
namespace {

using namespace geo;

constexpr float k_hole = std::numeric_limits<float>::quiet_NaN();
constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// height(column, row) for all cells, of 2 units, with coordinates of UTM.
template <class Height>
Raster<float> raster_of(int columns, int rows, const Height& height, double cell_size = 2.0) {
  Raster<float> raster({{690000.0, 5325000.0}, cell_size, columns, rows}, 0.0f);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      raster.at(column, row) = static_cast<float>(height(column, row));
  return raster;
}

/// Position over the grid, in cells from the centre of the north-western one.
glm::dvec3 over(const RasterGrid& grid, double column, double row, double z) {
  return {grid.north_west.x + (column + 0.5) * grid.cell_size,
          grid.north_west.y - (row + 0.5) * grid.cell_size, z};
}

/// Of the patch that a position lies over, by its four heights.
double height_at(const Raster<float>& raster, int column, int row, const glm::dvec3& position) {
  const RasterGrid& grid = raster.grid;
  const double u = (position.x - grid.north_west.x) / grid.cell_size - 0.5 - column,
               v = (grid.north_west.y - position.y) / grid.cell_size - 0.5 - row;
  return (1 - u) * (1 - v) * raster.at(column, row) + u * (1 - v) * raster.at(column + 1, row) +
         (1 - u) * v * raster.at(column, row + 1) + u * v * raster.at(column + 1, row + 1);
}

std::vector<Raster<float>> rasters(Random& random) {
  const auto hills = [](int column, int row) {
    return 600.0 + 8.0 * std::sin(0.5 * column) * std::cos(0.3 * row);
  };
  std::vector<Raster<float>> all;
  all.push_back(raster_of(37, 23, hills));
  all.push_back(raster_of(16, 17, [](int, int) { return 5.0; }));
  all.push_back(raster_of(30, 30, [&](int, int) { return random.below(3) == 0 ? 12.0 : 0.0; }));
  all.push_back(raster_of(40, 9, [&](int column, int row) {
    return random.below(6) == 0 ? double(k_hole) : hills(column, row);
  }));
  all.push_back(raster_of(2, 2, [&](int, int) { return random.between(-3, 3); }));
  all.push_back(raster_of(1, 9, hills));
  all.push_back(raster_of(1, 1, hills));
  all.push_back(
      raster_of(7, 7, [](int column, int row) { return (column + row) % 2 == 0 ? double(k_hole) : 1.0; }));
  return all;
}

/// Of all kinds: between positions around the surface, along rows, columns and diagonals through centres,
/// straight down, and within flat ground.
Ray ray_over(const Raster<float>& raster, Random& random) {
  const RasterGrid& grid = raster.grid;
  double low = k_infinity, high = -k_infinity;
  for (const float height : raster.values) {
    if (std::isnan(height)) continue;
    low = std::min<double>(low, height);
    high = std::max<double>(high, height);
  }
  const auto position = [&] {
    return over(grid, random.between(-2, grid.columns + 1), random.between(-2, grid.rows + 1),
                random.between(low - 2, high + 2));
  };
  const auto center = [&] {
    return over(grid, static_cast<double>(random.below(grid.columns)),
                static_cast<double>(random.below(grid.rows)), random.between(low, high));
  };
  const auto kind = random.below(7);
  const glm::dvec3 from = kind == 0 ? position() : center();
  glm::dvec3 way = position() - from;
  if (kind == 2) way = center() - from;
  if (kind == 3) way = {0.0, random.between(-1, 1), random.between(-0.1, 0.1)};
  if (kind == 4) way = {1.0, -1.0, 0.0};
  if (kind == 5) way = {0.0, 0.0, random.below(2) == 0 ? 1.0 : -1.0};
  if (kind == 6) way = {random.between(-1, 1), 0.0, 0.0};
  if (way == glm::dvec3(0.0)) way.z = 1.0;
  const double t_min = random.below(2) == 0 ? -k_infinity : random.between(-20, 5);
  return make_ray(from, way, t_min, random.below(2) == 0 ? k_infinity : random.between(0, 60));
}

TEST(TerrainSurface, answers_are_those_of_a_loop_over_all_patches_bit_for_bit) {
  Random random;
  int hits = 0;
  for (const Raster<float>& raster : rasters(random)) {
    const TerrainSurface terrain(raster);
    const TerrainFilter some = [](const TerrainHit& hit) { return (hit.column + hit.row) % 3 != 0; };
    for (int i = 0; i < 4000; ++i) {
      const Ray ray = ray_over(raster, random);
      const TerrainFilter counts = i % 4 == 0 ? some : TerrainFilter();
      const std::optional<TerrainHit> hit = terrain.closest(ray, counts);
      ASSERT_EQ(hit, terrain.closest_by_brute_force(ray, counts)) << i;
      ASSERT_EQ(terrain.occluded(ray, counts), hit.has_value()) << i;
      if (!hit) continue;
      ++hits;
      ASSERT_GE(hit->t, ray.t_min);
      ASSERT_LE(hit->t, ray.t_max);
      const glm::dvec3 met = ray.position(hit->t);
      ASSERT_NEAR(height_at(raster, hit->column, hit->row, met), met.z, 1e-6) << i;
      ASSERT_NEAR(glm::length(hit->normal), 1.0, 1e-12);
      ASSERT_LE(glm::dot(hit->normal, ray.direction), 0.0);
    }
  }
  EXPECT_GT(hits, 10000);
}

TEST(TerrainSurface, no_line_slips_from_above_to_below_at_centres_and_edges) {
  Random random;
  const Raster<float> raster = raster_of(33, 33, [&](int, int) { return random.between(0, 4); });
  const TerrainSurface terrain(raster);
  for (int i = 0; i < 20000; ++i) {
    // From above all heights through a centre, or a position on an edge, and on below all heights.
    const auto column = static_cast<double>(2 + random.below(29)),
               row = static_cast<double>(2 + random.below(29));
    const double share = i % 3 == 0 ? 0.0 : random.unit();
    const int c = static_cast<int>(column), r = static_cast<int>(row);
    const double z = (1 - share) * raster.at(c, r) + share * raster.at(c + 1, r);
    const glm::dvec3 through = over(raster.grid, column + share, row, z);
    glm::dvec3 way(random.between(-1, 1), random.between(-1, 1), -random.between(4.5, 9));
    if (i % 5 == 0) way.x = way.y;
    if (i % 7 == 0) way.y = 0.0;
    const Ray ray = make_ray(through - 1.2 * way, way, 0.0, 2.4 * glm::length(way));
    const std::optional<TerrainHit> hit = terrain.closest(ray);
    ASSERT_TRUE(hit) << i;
  }
}

TEST(TerrainSurface, a_saddle_is_met_where_its_formula_has_it_and_twice) {
  // z = u v over one patch of 2 x 2 units, u to the east and v to the south.
  const TerrainSurface terrain(raster_of(2, 2, [](int column, int row) { return column * row; }));
  ASSERT_EQ(terrain.patch_count(), 1u);
  const RasterGrid& grid = terrain.heights().grid;
  // Along the diagonal u + v = 1 the surface is an arch u (1 - u), 0.25 high in the middle.
  const auto along = [&](double z, double t_min = 0.0) {
    return make_ray(over(grid, 0, 1, z), {1, 1, 0}, t_min, 2.0 * std::sqrt(2.0));
  };
  const double way = 2.0 * std::sqrt(2.0);
  const auto first = terrain.closest(along(0.21));
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->t, 0.3 * way, 1e-9);
  const auto second = terrain.closest(along(0.21, 0.5 * way));
  ASSERT_TRUE(second) << "from below";
  EXPECT_NEAR(second->t, 0.7 * way, 1e-9);
  const auto counted =
      terrain.closest(along(0.21), [&](const TerrainHit& hit) { return hit.t > first->t + 0.1; });
  ASSERT_TRUE(counted) << "where the first crossing does not count, the second does";
  EXPECT_NEAR(counted->t, second->t, 1e-9);
  EXPECT_FALSE(terrain.occluded(along(0.2501)));
  EXPECT_TRUE(terrain.occluded(along(0.2499)));
  const auto down = terrain.closest(make_ray(over(grid, 0.25, 0.5, 10), {0, 0, -1}));
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->t, 10.0 - 0.125, 1e-9);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.25, 0.125, 1.0));
  EXPECT_NEAR(glm::distance(down->normal, normal), 0.0, 1e-9);
  const auto up = terrain.closest(make_ray(over(grid, 0.25, 0.5, -10), {0, 0, 1}));
  ASSERT_TRUE(up);
  EXPECT_NEAR(glm::distance(up->normal, -normal), 0.0, 1e-9);
}

TEST(TerrainSurface, a_patch_with_a_hole_at_a_corner_does_not_exist) {
  for (const float hole :
       {k_hole, std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
    Raster<float> raster = raster_of(4, 4, [](int, int) { return 1.0; });
    raster.at(1, 1) = hole;
    const TerrainSurface terrain(raster);
    EXPECT_EQ(terrain.patch_count(), 5u);
    EXPECT_TRUE(std::isnan(terrain.heights().at(1, 1)));
    for (const auto& [column, row, exists] : {std::tuple(0.5, 0.5, false),
                                              {1.5, 0.5, false},
                                              {1.5, 1.5, false},
                                              {2.5, 0.5, true},
                                              {0.5, 2.5, true},
                                              {2.5, 2.5, true},
                                              {-0.2, 0.5, false},
                                              {3.2, 2.5, false}})
      EXPECT_EQ(terrain.occluded(make_ray(over(raster.grid, column, row, 5), {0, 0, -1})), exists)
          << column << " " << row;
  }
  EXPECT_EQ(TerrainSurface(raster_of(1, 5, [](int, int) { return 1.0; })).patch_count(), 0u);
  EXPECT_TRUE(TerrainSurface(raster_of(1, 1, [](int, int) { return 1.0; })).bounds().empty());
}

TEST(TerrainSurface, bounds_hold_the_patches_and_any_finds_their_boxes) {
  Raster<float> raster = raster_of(9, 6, [](int column, int) { return column == 5 ? 7.0 : 1.0; });
  raster.at(0, 0) = k_hole;
  const TerrainSurface terrain(raster);
  const Bounds& bounds = terrain.bounds();
  EXPECT_EQ(bounds.min, over(raster.grid, 0, 5, 1));
  EXPECT_EQ(bounds.max, over(raster.grid, 8, 0, 7));
  EXPECT_TRUE(terrain.any([](const Bounds& box) { return box.max.z > 6.0; }));
  EXPECT_FALSE(terrain.any([](const Bounds& box) { return box.max.z > 8.0; }));
  int boxes = 0;
  EXPECT_FALSE(terrain.any([&](const Bounds& box) {
    boxes += box.max.x - box.min.x < 2.1 && box.max.y - box.min.y < 2.1 ? 1 : 0;
    return box.max.x - box.min.x > 2.1 || box.max.y - box.min.y > 2.1;
  }));
  EXPECT_EQ(boxes, 39) << "each patch once";
}

/// The highest slope of the surface above the eye by sampling it along a direction.
double sampled_slope(const Raster<float>& raster, const glm::dvec3& eye, const glm::dvec2& direction) {
  constexpr double k_step = 0.003;
  double best = 0.0;
  for (double t = k_step; t < 200.0; t += k_step) {
    const glm::dvec3 position = eye + t * glm::dvec3(direction, 0.0);
    const int column = static_cast<int>(
                  std::floor((position.x - raster.grid.north_west.x) / raster.grid.cell_size - 0.5)),
              row = static_cast<int>(
                  std::floor((raster.grid.north_west.y - position.y) / raster.grid.cell_size - 0.5));
    if (column < 0 || row < 0 || column + 1 >= raster.grid.columns || row + 1 >= raster.grid.rows) continue;
    const double height = height_at(raster, column, row, position);
    if (std::isfinite(height)) best = std::max(best, (height - eye.z) / t);
  }
  return best;
}

TEST(TerrainSurface, horizon_slope_is_the_highest_of_all_positions_along_the_direction) {
  Random random;
  for (const Raster<float>& raster : rasters(random)) {
    const TerrainSurface terrain(raster);
    for (int i = 0; i < 40; ++i) {
      const auto column = static_cast<int>(random.below(raster.grid.columns)),
                 row = static_cast<int>(random.below(raster.grid.rows));
      const double height = raster.at(column, row);
      if (std::isnan(height)) continue;
      const glm::dvec3 eye =
          over(raster.grid, column, row, height + (i % 2 == 0 ? 0.0 : random.between(0, 3)));
      const double angle = random.between(0, 7);
      const glm::dvec2 direction(std::sin(angle), std::cos(angle));
      const double slope = terrain.horizon_slope(eye, direction),
                   sampled = sampled_slope(raster, eye, direction);
      EXPECT_GE(slope, sampled - 1e-5) << i;
      EXPECT_LE(slope, sampled + 0.02 * (1.0 + sampled)) << i;
      EXPECT_EQ(terrain.horizon_slope(eye, direction, slope), slope);
      EXPECT_EQ(terrain.horizon_slope(eye, direction, slope + 1.0), slope + 1.0) << "nothing is above that";
    }
  }
}

TEST(TerrainSurface, horizon_slope_separates_lines_that_meet_the_surface_from_free_ones) {
  Random random;
  const Raster<float> raster = raster_of(
      37, 23, [](int column, int row) { return 600.0 + 8.0 * std::sin(0.5 * column) * std::cos(0.3 * row); });
  const TerrainSurface terrain(raster);
  for (int i = 0; i < 500; ++i) {
    const auto column = static_cast<int>(random.below(37)), row = static_cast<int>(random.below(23));
    const glm::dvec3 eye = over(raster.grid, column, row, raster.at(column, row) + 0.01);
    const double angle = random.between(0, 7);
    constexpr glm::dvec2 k_along[] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    const glm::dvec2 direction =
        i % 5 == 0 ? k_along[i / 5 % 4] : glm::dvec2(std::sin(angle), std::cos(angle));
    const double slope = terrain.horizon_slope(eye, direction);
    EXPECT_FALSE(terrain.occluded(make_ray(eye, {direction, slope + 1e-6}, 0.0)));
    if (slope > 0.0) EXPECT_TRUE(terrain.occluded(make_ray(eye, {direction, slope - 1e-6}, 0.0))) << i;
  }
}

}  // namespace
}  // namespace alidade::test
