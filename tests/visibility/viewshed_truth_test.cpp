// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "simulation/courtyard.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;
using namespace simulation;

namespace {

/// Whether the site itself, whose surfaces are known exactly, lets the eye see positions on the ground.
Raster<float> seen_in_truth(const Site& site, const Ground& ground, const RasterGrid& grid,
                            const glm::dvec3& eye) {
  constexpr double k_above_ground = 0.02, k_behind_eye = 1e-6;
  Raster<float> seen(grid, 0.0f);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const glm::dvec2 position = grid.center(column, row);
      const glm::dvec3 way = glm::dvec3(position, *ground.at(position) + k_above_ground) - eye;
      seen.at(column, row) = !site.occluded(make_ray(eye, way, k_behind_eye, glm::length(way)));
    }
  }
  return seen;
}

/// Whether all cells around one have its value.
bool is_inside(const Raster<float>& raster, int column, int row) {
  for (int y = row - 1; y <= row + 1; ++y) {
    for (int x = column - 1; x <= column + 1; ++x) {
      if (raster.at(x, y) != raster.at(column, row)) return false;
    }
  }
  return true;
}

TEST(ViewshedTruthTest, the_map_of_a_scanned_yard_is_that_of_the_yard_itself) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "alidade_viewshed_truth.las";
  GenerateOptions options;
  options.point_count = 500'000;
  options.overwrite = true;
  generate_courtyard(file, options);
  const PointCloud cloud = read_cloud(file);
  std::filesystem::remove(file);
  const Octree octree = build(cloud);
  const Occluders occluders(octree, {});
  const Ground ground = make_ground(occluders.octree(), cloud.classifications, {});
  const Site site = courtyard();
  const RasterGrid grid = grid_over(octree.bounds(), 0.5);
  // A person in the yard, the same on a step ladder, a camera below the eaves.
  for (const glm::dvec3 eye : {glm::dvec3(5, -10, 1.7), {5, -10, 3.7}, {23, -15.2, 6.8}}) {
    Observer observer;
    observer.position = site.origin() + eye;
    const Viewshed seen = viewshed(occluders, ground, {&observer, 1}, grid, {});
    const Raster<float> truth = seen_in_truth(site, ground, grid, observer.position);
    int cells = 0, unknown = 0, agree = 0, inside = 0, agree_inside = 0;
    for (int row = 1; row + 1 < grid.rows; ++row) {
      for (int column = 1; column + 1 < grid.columns; ++column) {
        // Cells at the outer edge are unscanned.
        const bool is_unknown = std::isnan(seen.values.at(column, row));
        unknown += is_unknown;
        if (is_unknown) continue;
        const bool same = seen.values.at(column, row) == truth.at(column, row);
        ++cells;
        agree += same;
        if (!is_inside(truth, column, row)) continue;
        ++inside;
        agree_inside += same;
      }
    }
    const double all = 100.0 * agree / cells, away = 100.0 * agree_inside / inside;
    std::printf("eye %.1f high: %.2f %% of the cells are right, %.2f %% away from the edge of what is seen\n",
                eye.z, all, away);
    EXPECT_GT(unknown, 0);
    EXPECT_LT(unknown, cells / 25);
    EXPECT_GE(all, 98.0);
    EXPECT_GE(away, 99.3);
  }
}

}  // namespace
}  // namespace alidade::test
