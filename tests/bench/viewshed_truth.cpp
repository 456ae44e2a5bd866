// SPDX-License-Identifier: MIT
// viewshed_truth: maps of what an observer sees of an elevation raster, by any program, against exact lines
// of sight over its bilinear surface.
//   viewshed_truth town|hills|elevation DEM.tif              writes a raster of viewshed_terrain_test.cpp
//   viewshed_truth DEM.tif COLUMN ROW EYE_HEIGHT MAP.tif...  prints a row of a table in Markdown for each map
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "base/error.h"
#include "geo/raster_file.h"
#include "tests/visibility/exact_terrain.h"
#include "tests/visibility/known_terrains.h"

namespace alidade::test {

using namespace geo;

namespace {

Raster<float> known_terrain(const std::string& name) {
  if (name == "hills") return hills(120);
  // The town of the test of that name.
  Random random("a_town_is_seen_as_by_exact_lines");
  if (name == "town") return whole_town(town(140, random));
  const auto elevation = elevation_of_r_viewshed();
  if (name != "elevation" || !elevation)
    throw input_error("unknown raster", "town, hills or elevation", name);
  return *elevation;
}

/// 1: visible by exact lines from the middle of a cell to the middles of all on the surface.
std::vector<std::uint8_t> seen_in_truth(const Raster<float>& heights, const glm::ivec2& cell,
                                        double eye_height) {
  const glm::dvec3 eye = above(heights, cell, eye_height);
  std::vector<std::uint8_t> seen(heights.values.size());
  for (int row = 0; row < heights.grid.rows; ++row) {
    for (int column = 0; column < heights.grid.columns; ++column) {
      const glm::dvec2 center = heights.grid.center(column, row);
      const double height = heights.at(column, row);
      seen[heights.grid.index(column, row)] =
          !std::isnan(height) && !clearance_of(heights, eye, {center.x, center.y, height}).crosses;
    }
  }
  return seen;
}

/// Cells above 0 are visible, those without a value do not count.
void print_row(const Raster<float>& heights, const std::vector<std::uint8_t>& truth,
               const std::filesystem::path& file) {
  const Raster<float> map = read_heights(file).heights;
  if (map.grid != heights.grid) throw file_error(file, "another grid than that of the elevation raster");
  std::size_t both = 0, falsely_seen = 0, falsely_hidden = 0, without = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (std::isnan(heights.values[i])) continue;
    const bool is_seen = map.values[i] > 0.0f, in_truth = truth[i] != 0;
    without += std::isnan(map.values[i]);
    if (std::isnan(map.values[i])) continue;
    both += is_seen && in_truth;
    falsely_seen += is_seen && !in_truth;
    falsely_hidden += !is_seen && in_truth;
  }
  const auto percent = [&](std::size_t rest) {
    return 100.0 * static_cast<double>(both) / static_cast<double>(both + rest);
  };
  fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {} |\n", file.filename().string(),
             percent(falsely_seen + falsely_hidden), percent(falsely_seen), percent(falsely_hidden), without);
}

int run(const std::vector<std::string>& words) {
  if (words.size() == 2) {
    const Raster<float> heights = known_terrain(words[0]);
    const RasterBand band{.values = std::span<const float>(heights.values)};
    write_raster(words[1], {.grid = heights.grid, .bands = {band}, .crs = {}}, true);
    return 0;
  }
  if (words.size() < 5) throw input_error("missing arguments", "DEM.tif COLUMN ROW EYE_HEIGHT MAP.tif...");
  const Raster<float> heights = read_heights(words[0]).heights;
  const std::vector<std::uint8_t> truth =
      seen_in_truth(heights, {std::stoi(words[1]), std::stoi(words[2])}, std::stod(words[3]));
  fmt::print("| map | IoU, % | precision, % | recall, % | cells without a value |\n|---|--:|--:|--:|--:|\n");
  for (std::size_t i = 4; i < words.size(); ++i) print_row(heights, truth, words[i]);
  return 0;
}

}  // namespace
}  // namespace alidade::test

int main(int count, char** words) {
  try {
    return alidade::test::run({words + 1, words + count});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
