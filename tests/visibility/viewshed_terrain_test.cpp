// SPDX-License-Identifier: MIT
// Viewsheds on elevation rasters alone, against lines of sight over the bilinear surface that are computed in
// another way (exact_terrain.h).
#include <gdal.h>
#include <gdal_alg.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/support/absent_data.h"
#include "tests/visibility/ascii_grid.h"
#include "tests/visibility/exact_terrain.h"
#include "tests/visibility/known_terrains.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

struct Agreement {
  std::size_t both = 0, only_seen = 0, only_exact = 0, neither = 0;
  /// Of only_seen: less than a millimetre of the line is below the surface, near its end on it.
  std::size_t within_contact = 0;

  double intersection_over_union() const {
    return 100.0 * static_cast<double>(both) / static_cast<double>(both + only_seen + only_exact);
  }
};

/// An observer so high above the ground at a position in cells.
Observer observer_over(const Raster<float>& heights, const glm::dvec2& cell, double eye_height) {
  Observer observer;
  observer.position = above(heights, cell, eye_height);
  return observer;
}

Viewshed our_map(const Raster<float>& heights, const Observer& observer,
                 const ViewshedOptions& viewshed_options) {
  return viewshed(occluders_of(heights), Ground(TerrainSurface(heights)), {&observer, 1}, heights.grid,
                  viewshed_options);
}

/// Of gdal_viewshed with `-cc 0`, for targets on the ground: above 0 where it sees the cell.
Raster<float> gdal_map(Raster<float> heights, const Observer& observer, double eye_height) {
  GDALAllRegister();
  const RasterGrid& grid = heights.grid;
  const GDALDatasetH file =
      GDALCreate(GDALGetDriverByName("MEM"), "", grid.columns, grid.rows, 1, GDT_Float32, nullptr);
  std::array<double, 6> transform = {grid.north_west.x, grid.cell_size, 0.0, grid.north_west.y, 0.0,
                                     -grid.cell_size};
  GDALSetGeoTransform(file, transform.data());
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 0, 0, grid.columns, grid.rows,
                         heights.values.data(), grid.columns, grid.rows, GDT_Float32, 0, 0),
            CE_None);
  const GDALDatasetH seen = GDALViewshedGenerate(
      GDALGetRasterBand(file, 1), "MEM", "", nullptr, observer.position.x, observer.position.y, eye_height,
      0.0, 255.0, 0.0, 0.0, -1.0, 0.0, GVM_Edge, 0.0, nullptr, nullptr, GVOT_NORMAL, nullptr);
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(seen, 1), GF_Read, 0, 0, grid.columns, grid.rows,
                         heights.values.data(), grid.columns, grid.rows, GDT_Float32, 0, 0),
            CE_None);
  GDALClose(seen);
  GDALClose(file);
  return heights;
}

/// Of a map, above 0 where the cell is seen, with the exact one.
Agreement compare(const Raster<float>& map, const Raster<float>& heights, const Observer& observer,
                  double target_height) {
  Agreement agreement;
  for (int row = 0; row < heights.grid.rows; ++row) {
    for (int column = 0; column < heights.grid.columns; ++column) {
      const double height = heights.at(column, row);
      EXPECT_EQ(std::isnan(map.at(column, row)), std::isnan(height));
      if (std::isnan(height)) continue;
      const glm::dvec2 center = heights.grid.center(column, row);
      const Clearance exact =
          clearance_of(heights, observer.position, {center.x, center.y, height + target_height});
      const bool is_seen = map.at(column, row) > 0.0f;
      ++(is_seen ? (exact.crosses ? agreement.only_seen : agreement.both)
                 : (exact.crosses ? agreement.neither : agreement.only_exact));
      if (is_seen && exact.crosses && exact.lowest > -k_mesh_contact) ++agreement.within_contact;
    }
  }
  return agreement;
}

/// Expects our map of these heights to agree with the exact one; returns the agreement.
Agreement expect_exact(const Raster<float>& heights, const glm::dvec2& cell, double eye_height,
                       double target_height) {
  const Observer observer = observer_over(heights, cell, eye_height);
  const Agreement agreement = compare(our_map(heights, observer, {.target_height = target_height}).values,
                                      heights, observer, target_height);
  const std::string where = std::to_string(cell.x) + " " + std::to_string(cell.y);
  EXPECT_EQ(agreement.only_seen, agreement.within_contact) << where;
  EXPECT_EQ(agreement.only_exact, 0u) << where;
  EXPECT_GE(agreement.intersection_over_union(), 99.7) << where;
  EXPECT_GT(agreement.both, 100u) << where;
  EXPECT_GT(agreement.neither, 100u) << where;
  return agreement;
}

/// Expects our map to agree with the exact one better than that of gdal_viewshed, from the centre of a cell to
/// the ground.
void expect_better_than_gdal(const std::string& name, const Raster<float>& heights, const glm::ivec2& cell,
                             double eye_height) {
  const double ours = expect_exact(heights, cell, eye_height, 0.0).intersection_over_union();
  const Observer observer = observer_over(heights, cell, eye_height);
  const double theirs =
      compare(gdal_map(heights, observer, eye_height), heights, observer, 0.0).intersection_over_union();
  std::printf(
      "%s, cell %d %d: intersection over union with exact lines: here %.2f %%, gdal_viewshed %.2f %%\n",
      name.c_str(), cell.x, cell.y, ours, theirs);
  EXPECT_GT(ours, theirs);
}

TEST(ViewshedTerrain, a_hilly_raster_is_seen_as_by_exact_lines) {
  const Raster<float> heights = hills(120);
  for (const glm::dvec2 cell : {glm::dvec2(60, 60), {10.3, 80.7}, {99.5, 20.0}})
    for (const double target : {0.0, 1.7}) expect_exact(heights, cell, 2.0, target);
  for (const glm::ivec2 cell : {glm::ivec2(60, 60), {20, 90}})
    expect_better_than_gdal("hills", heights, cell, 2.0);
}

TEST(ViewshedTerrain, a_town_is_seen_as_by_exact_lines) {
  Random random;
  const Raster<float> heights = town(140, random);
  for (const glm::dvec2 cell : {glm::dvec2(70, 70), {20.4, 33.2}, {120.0, 100.6}})
    for (const double target : {0.0, 1.7}) expect_exact(heights, cell, 10.0, target);
  const Raster<float> whole = whole_town(heights);
  for (const glm::ivec2 cell : {glm::ivec2(70, 70), {20, 33}})
    expect_better_than_gdal("town", whole, cell, 10.0);
}

TEST(ViewshedTerrain, heights_seen_are_those_of_exact_lines) {
  const Raster<float> heights = hills(40);
  const Observer observer = observer_over(heights, {20, 20}, 2.0);
  const Viewshed seen = our_map(heights, observer, {.mode = ViewshedMode::height, .highest = 500.0});
  int hidden = 0;
  for (int row = 0; row < heights.grid.rows; ++row) {
    for (int column = 0; column < heights.grid.columns; ++column) {
      const glm::dvec2 center = heights.grid.center(column, row);
      const double lowest = seen.values.at(column, row);
      const auto clear = [&](double height) {
        return !clearance_of(heights, observer.position,
                             {center.x, center.y, heights.at(column, row) + height})
                    .crosses;
      };
      // An end on the ground may lie a millimetre in it.
      EXPECT_TRUE(clear(std::max(lowest, 0.001))) << column << " " << row;
      if (lowest < 0.02) continue;
      ++hidden;
      EXPECT_FALSE(clear(lowest - 0.0101)) << column << " " << row;
    }
  }
  EXPECT_GT(hidden, 500);
}

TEST(ViewshedTerrain, test_data_of_r_viewshed_is_seen_as_by_exact_lines) {
  const std::optional<Raster<float>> elevation = elevation_of_r_viewshed();
  if (!elevation) GTEST_SKIP() << absent("grass_elevation.ascii of ../shared/data/viewshed", 4);
  const Raster<float>& heights = *elevation;
  // The first one is that of the published map of r.viewshed.
  for (const glm::ivec2 cell : {*cell_at(heights.grid, {634720, 216180}), {40, 100}, {110, 40}})
    expect_better_than_gdal("elevation", heights, cell, 1.72);
  const Raster<double> published =
      read_ascii_grid(std::filesystem::path(ALIDADE_SHARED_DATA) / "viewshed" / "grass_lake_viewshed.ascii");
  Raster<float> map(heights.grid, 0.0f);
  std::ranges::transform(published.values, map.values.begin(),
                         [](double angle) { return std::isnan(angle) ? 0.0f : 1.0f; });
  const glm::dvec2 lake(*cell_at(heights.grid, {634720, 216180}));
  std::printf("r.viewshed: %.2f %%\n",
              compare(map, heights, observer_over(heights, lake, 1.72), 0.0).intersection_over_union());
}

}  // namespace
}  // namespace alidade::test
