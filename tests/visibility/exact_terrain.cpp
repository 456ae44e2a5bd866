// SPDX-License-Identifier: MIT
#include "tests/visibility/exact_terrain.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <vector>

#include "geo/terrain_surface.h"
#include "octree/build.h"
#include "tests/visibility/ascii_grid.h"
#include "visibility/raster/ground.h"

namespace alidade::test {

using namespace geo;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;

/// x and y in cells from the centre of the north-western one, z a height.
glm::dvec3 on_grid(const RasterGrid& grid, const glm::dvec3& position) {
  return {(position.x - grid.north_west.x) / grid.cell_size - 0.5,
          (grid.north_west.y - position.y) / grid.cell_size - 0.5, position.z};
}

/// Of the patch around `middle`, continued to a position; NaN without a patch.
double surface_at(const Raster<float>& heights, const glm::dvec3& position, const glm::dvec3& middle) {
  const int column = static_cast<int>(std::floor(middle.x)), row = static_cast<int>(std::floor(middle.y));
  if (column < 0 || row < 0 || column + 1 >= heights.grid.columns || row + 1 >= heights.grid.rows)
    return std::numeric_limits<double>::quiet_NaN();
  const double u = position.x - column, v = position.y - row;
  return (1 - v) * ((1 - u) * heights.at(column, row) + u * heights.at(column + 1, row)) +
         v * ((1 - u) * heights.at(column, row + 1) + u * heights.at(column + 1, row + 1));
}

/// A quadratic of [0, 1], by its values at 0, 1/2 and 1.
struct Quadratic {
  double constant, linear, square;

  Quadratic(double begin, double middle, double end)
      : constant(begin),
        linear(4.0 * middle - 3.0 * begin - end),
        square(2.0 * (begin + end - 2.0 * middle)) {}

  double at(double x) const { return constant + x * (linear + x * square); }
};

/// A line between two edges of patches.
struct Piece {
  double begin, end;                               ///< shares of the line
  double line_begin, line_end;                     ///< heights of the line
  double begin_height, middle_height, end_height;  ///< of the surface; NaN in a hole
};

std::vector<Piece> pieces_of(const Raster<float>& heights, const glm::dvec3& eye, const glm::dvec3& target) {
  const glm::dvec3 from = on_grid(heights.grid, eye), way = on_grid(heights.grid, target) - from;
  std::vector<double> shares{0.0, 1.0};
  for (int axis = 0; axis < 2; ++axis) {
    const int count = axis == 0 ? heights.grid.columns : heights.grid.rows;
    const double low = std::max(std::min(from[axis], from[axis] + way[axis]), 0.0),
                 high = std::min(std::max(from[axis], from[axis] + way[axis]), count - 1.0);
    for (double line = std::ceil(low); line <= high; line += 1.0)
      if (way[axis] != 0.0) shares.push_back(std::clamp((line - from[axis]) / way[axis], 0.0, 1.0));
  }
  std::ranges::sort(shares);
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < shares.size(); ++i) {
    const double begin = shares[i], end = shares[i + 1];
    if (end - begin < 1e-12) continue;
    const glm::dvec3 first = from + begin * way, middle = from + 0.5 * (begin + end) * way,
                     last = from + end * way;
    pieces.push_back({begin, end, first.z, last.z, surface_at(heights, first, middle),
                      surface_at(heights, middle, middle), surface_at(heights, last, middle)});
  }
  return pieces;
}

}  // namespace

Clearance clearance_of(const Raster<float>& heights, const glm::dvec3& eye, const glm::dvec3& target) {
  constexpr double k_rounding = 1e-6;
  Clearance found;
  bool was_above = false, was_below = false;  // since the last hole
  for (const Piece& piece : pieces_of(heights, eye, target)) {
    if (!std::isfinite(piece.middle_height)) {
      was_above = was_below = false;
      continue;
    }
    const double first = piece.line_begin - piece.begin_height, last = piece.line_end - piece.end_height;
    const Quadratic clearance(first, 0.5 * (piece.line_begin + piece.line_end) - piece.middle_height, last);
    double low = std::min(first, last), high = std::max(first, last);
    const double turn = clearance.square != 0.0 ? -clearance.linear / (2.0 * clearance.square) : -1.0;
    if (turn > 0.0 && turn < 1.0) {
      low = std::min(low, clearance.at(turn));
      high = std::max(high, clearance.at(turn));
    }
    was_above = was_above || high > k_rounding;
    was_below = was_below || low < -k_rounding;
    found.crosses = found.crosses || (was_above && was_below);
    found.lowest = std::min(found.lowest, low);
  }
  return found;
}

double exact_horizon(const Raster<float>& heights, const glm::dvec3& eye, double azimuth) {
  const RasterGrid& grid = heights.grid;
  const double reach = 2.0 * grid.cell_size * (grid.columns + grid.rows);
  const glm::dvec3 along(std::sin(azimuth * k_degree), std::cos(azimuth * k_degree), 0.0);
  double steepest = -std::numeric_limits<double>::infinity();
  for (const Piece& piece : pieces_of(heights, eye, eye + reach * along)) {
    if (!std::isfinite(piece.middle_height)) continue;
    // With d the distance, from the piece's heights above the eye a + b d + c d^2: the tangent
    // a / d + b + c d.
    const double begin = reach * piece.begin, length = reach * (piece.end - piece.begin);
    const Quadratic rise(piece.begin_height - eye.z, piece.middle_height - eye.z, piece.end_height - eye.z);
    const double c = rise.square / (length * length), b = rise.linear / length - 2.0 * c * begin,
                 a = rise.constant - begin * (b + c * begin);
    const auto see = [&](double distance) {
      // An eye on the surface looks along it.
      const double start = std::fabs(a) < 1e-7 && begin == 0.0 ? 0.0 : a / distance;
      steepest = std::max(steepest, start + b + c * distance);
    };
    if (begin > 0.0)
      see(begin);
    else if (std::fabs(a) < 1e-7)
      steepest = std::max(steepest, b);
    see(begin + length);
    const double turn = c != 0.0 && a / c > 0.0 ? std::sqrt(a / c) : -1.0;
    if (turn > begin && turn < begin + length) see(turn);
  }
  return std::atan(steepest) / k_degree;
}

double exact_sky_view(const Raster<float>& heights, const glm::dvec3& eye, int azimuths) {
  double sum = 0.0;
  for (int i = 0; i < azimuths; ++i) {
    const double cosine =
        std::cos(std::max(exact_horizon(heights, eye, 360.0 * (i + 0.5) / azimuths), 0.0) * k_degree);
    sum += cosine * cosine;
  }
  return sum / azimuths;
}

std::optional<Raster<float>> elevation_of_r_viewshed() {
  const std::filesystem::path file =
      std::filesystem::path(ALIDADE_SHARED_DATA) / "viewshed" / "grass_elevation.ascii";
  if (!std::filesystem::exists(file)) return std::nullopt;
  const Raster<double> elevation = read_ascii_grid(file);
  Raster<float> heights(elevation.grid, 0.0f);
  std::ranges::transform(elevation.values, heights.values.begin(),
                         [](double height) { return static_cast<float>(height); });
  return heights;
}

visibility::Occluders occluders_of(const Raster<float>& heights) {
  visibility::OccluderOptions options;
  options.terrain = std::make_shared<const TerrainSurface>(heights);
  return visibility::Occluders(build(PointCloud()), options);
}

glm::dvec3 above(const Raster<float>& heights, const glm::dvec2& cell, double height) {
  const RasterGrid& grid = heights.grid;
  const glm::dvec2 foot(grid.north_west.x + (cell.x + 0.5) * grid.cell_size,
                        grid.north_west.y - (cell.y + 0.5) * grid.cell_size);
  return {foot.x, foot.y, *visibility::Ground(TerrainSurface(heights)).at(foot) + height};
}

}  // namespace alidade::test
