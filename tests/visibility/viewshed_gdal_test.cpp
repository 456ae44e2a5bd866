// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "octree/build.h"
#include "tests/support/absent_data.h"
#include "tests/visibility/ascii_grid.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

using nlohmann::json;

const std::filesystem::path k_file =
    std::filesystem::path(ALIDADE_SHARED_DATA) / "viewshed" / "gdal_small_cases.json";

// gdal_viewshed tests lines from cell to cell: an eye of height 0 is on its cell, every neighbour is visible,
// and the line between the middles of two cells blocks. Points have no cells. They are put on the surface
// between the middles, and then differ in two ways:
// - An eye of height 0 is in the surface. On a ridge it grazes both flanks, so that neighbours are seen from
//   a little above them on ("all_visible", and cells beside the eye in general).
// - A flank that begins at the eye's foot is the eye's own surface, and one that ends at the target's foot
//   the target's own. A hill one cell wide between the two has no other surface, so it hides nothing
//   ("row_1", cell 4; "simple_height", columns 0 and 1). From a metre above the ground this does not happen.
// Elsewhere both agree to within what discs stand over a sharp edge.

/// Lowest heights seen on a small grid of the tests of gdal_viewshed, as ground of points. The eye is a hair
/// above its height of zero.
Raster<float> heights_seen(const json& source) {
  constexpr double k_spacing = 0.05, k_eye = 0.02;
  const int columns = source.at("cols"), rows = source.at("rows");
  const RasterGrid grid{{0.0, static_cast<double>(rows)}, 1.0, columns, rows};
  Raster<double> elevation(grid, 0.0);
  elevation.values = source.at("dem").get<HugeVector<double>>();
  const PointCloud cloud = cloud_on(elevation, k_spacing);
  const Octree octree = build(cloud);
  const Occluders occluders(octree, {});
  const Ground ground = make_ground(octree, cloud.classifications, {});
  const glm::dvec2 position = grid.center(source.at("observer").at(0), source.at("observer").at(1));
  Observer observer;
  observer.position = {position.x, position.y, interpolated(elevation, position) + k_eye};
  return viewshed(occluders, ground, {&observer, 1}, grid, {.mode = ViewshedMode::height, .highest = 50.0})
      .values;
}

class ViewshedGdalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ifstream stream(k_file);
    if (!stream) GTEST_SKIP() << absent(k_file.string());
    const json all = json::parse(stream);
    for (const json& one : all.at("cases")) cases_[one.at("name")] = one;
  }
  std::map<std::string, json> cases_;
};

TEST_F(ViewshedGdalTest, heights_along_rows_agree_with_gdal_viewshed) {
  int compared = 0;
  for (const char* const name : {"row_1", "row_2", "row_3", "row_4", "row_5"}) {
    const json& source = cases_.at(name);
    const Raster<float> seen = heights_seen(source);
    const int eye = source.at("observer").at(0);
    for (int column = 0; column < seen.grid.columns; ++column) {
      const bool between_feet = source.at("name") == "row_1" && column == 4;
      if (std::abs(column - eye) < 2 || between_feet) continue;
      EXPECT_NEAR(seen.at(column, 0),
                  source.at("min_height_ground").at(static_cast<std::size_t>(column)).get<double>(), 0.2)
          << name << " " << column;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 27);
}

TEST_F(ViewshedGdalTest, heights_over_a_small_grid_agree_where_no_flank_ends_at_the_eye) {
  const json& source = cases_.at("simple_height");
  const Raster<float> seen = heights_seen(source);
  for (int row = 0; row < 5; ++row) {
    for (int column = 2; column < 5; ++column) {
      if (std::max(std::abs(column - 2), std::abs(row - 2)) < 2) continue;
      const std::size_t i = seen.grid.index(column, row);
      const double lowest =
          source.at("observable_height").at(i).get<double>() - source.at("dem").at(i).get<double>();
      EXPECT_NEAR(seen.values[i], std::max(0.0, lowest), 0.55) << column << " " << row;
    }
  }
}

TEST_F(ViewshedGdalTest, neighbours_are_seen_from_a_little_above_them_on) {
  const Raster<float> seen = heights_seen(cases_.at("all_visible"));
  for (const auto& [column, row] : {std::pair(0, 1), {2, 1}}) EXPECT_LT(seen.at(column, row), 0.3f);
}

}  // namespace
}  // namespace alidade::test
