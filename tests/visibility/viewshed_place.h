// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <span>

#include "octree/build.h"
#include "tests/support/random.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

/// Level ground, 60 x 60 around the origin, and what a test adds to it.
class Field {
 public:
  explicit Field(double noise = 0.0) {
    cloud_.lattice.scale = glm::dvec3(0.0001);
    sheet({-30, -30, 0}, {60, 0, 0}, {0, 60, 0}, 2, noise);
  }

  /// Points on a parallelogram, some 0.25 apart; height above it by chance, as far as the noise.
  void sheet(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, std::uint8_t point_class,
             double noise = 0.0) {
    const double area = glm::length(glm::cross(u, v));
    const glm::dvec3 normal = glm::cross(u, v) / area;
    for (int i = 0; i < 16.0 * area; ++i) {
      const glm::dvec3 position = corner + random_.unit() * u + random_.unit() * v;
      cloud_.positions.push_back(
          *to_lattice(cloud_.lattice, position + random_.between(-noise, noise) * normal));
      cloud_.classifications.push_back(point_class);
    }
  }
  void wall(double x, double y0, double y1, double bottom, double top) {
    sheet({x, y0, bottom}, {0, y1 - y0, 0}, {0, 0, top - bottom}, 6);
  }

  void point(const glm::dvec3& position) {
    cloud_.positions.push_back(*to_lattice(cloud_.lattice, position));
    cloud_.classifications.push_back(5);
  }

  /// Makes the index; nothing is added afterwards.
  const Occluders& occluders() {
    if (!occluders_) occluders_.emplace(build(cloud_), OccluderOptions{});
    return *occluders_;
  }
  const Ground& ground() {
    if (!ground_) ground_.emplace(make_ground(occluders().octree(), cloud_.classifications, {}));
    return *ground_;
  }
  Viewshed seen(std::span<const Observer> observers, const ViewshedOptions& options = {}) {
    return viewshed(occluders(), ground(), observers, grid(), options);
  }
  static RasterGrid grid() { return grid_over({{-28, -28, 0}, {28, 28, 0}}, 2.0); }

 private:
  Random random_;
  PointCloud cloud_;
  std::optional<Occluders> occluders_;
  std::optional<Ground> ground_;
};

/// How far the discs of these points may extend beyond the edge of the surface they were taken from, and how
/// far before it they may end.
inline constexpr double k_edge = 0.5, k_before_edge = 0.2;

inline Observer at(double x, double y, double z) {
  Observer observer;
  observer.position = {x, y, z};
  return observer;
}

/// Calls check(value, middle of the cell) for the cells that are not near the given x, where a line is
/// neither here nor there.
template <class Check>
void for_cells(const Viewshed& seen, const Check& check) {
  const RasterGrid& grid = seen.values.grid;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column)
      check(seen.values.at(column, row), grid.center(column, row));
  }
}

}  // namespace alidade::test
