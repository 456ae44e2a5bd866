// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "octree/build.h"
#include "tests/support/absent_data.h"
#include "tests/visibility/ascii_grid.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

const std::filesystem::path k_folder = std::filesystem::path(ALIDADE_SHARED_DATA) / "viewshed";

TEST(ViewshedGrassTest, a_bare_earth_cloud_agrees_with_r_viewshed) {
  if (!std::filesystem::exists(k_folder)) GTEST_SKIP() << absent(k_folder.string());
  const Raster<double> elevation = read_ascii_grid(k_folder / "grass_elevation.ascii"),
                       published = read_ascii_grid(k_folder / "grass_lake_viewshed.ascii");
  ASSERT_EQ(elevation.grid, published.grid);
  const PointCloud cloud = cloud_on(elevation, 2.0);
  const Octree octree = build(cloud);
  const Ground ground = make_ground(octree, cloud.classifications, {});
  const Occluders occluders(octree, {});
  // r.viewshed puts the observer into the middle of its cell.
  const glm::dvec2 position(634725, 216175);
  Observer observer;
  observer.position = {position.x, position.y, interpolated(elevation, position) + 1.72};
  const Viewshed seen = viewshed(occluders, ground, {&observer, 1}, elevation.grid, {});
  std::size_t agree = 0, only_we = 0, only_grass = 0;
  for (std::size_t i = 0; i < published.values.size(); ++i) {
    const bool they = !std::isnan(published.values[i]), we = seen.values.values[i] > 0.0f;
    agree += they == we;
    only_we += we && !they;
    only_grass += they && !we;
  }
  const double share = 100.0 * static_cast<double>(agree) / static_cast<double>(published.values.size());
  std::printf("agreement with r.viewshed: %.2f %% (only here %zu, only there %zu)\n", share, only_we,
              only_grass);
  EXPECT_GE(share, 99.05);
}

}  // namespace
}  // namespace alidade::test
