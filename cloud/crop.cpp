// SPDX-License-Identifier: MIT
#include "cloud/select_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "cloud/keep_rows.h"
#include "cloud/polygon_strips.h"

namespace alidade {
namespace {

constexpr std::size_t k_rows_at_once = 1 << 20;
constexpr std::size_t k_grain = 4096;

/// How far outside a point still counts as on the border, per axis.
glm::dvec3 border_of(const Lattice& lattice) {
  glm::dvec3 border;
  for (int axis = 0; axis < 3; ++axis)
    border[axis] = std::max(1e-3 * lattice.scale[axis], 1e-15 * std::abs(lattice.offset[axis]));
  return border;
}

/// Keeps the points at places where `stays` says so; it is asked from many threads.
template <class Stays>
void keep_places(PointCloud& cloud, const Stays& stays, const Progress& progress) {
  const std::size_t size = cloud.size();
  std::vector<std::uint8_t> marks(size);
  for (std::size_t first = 0; first < size; first += k_rows_at_once) {
    const std::size_t end = std::min(first + k_rows_at_once, size);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(first, end, k_grain),
                      [&](const tbb::blocked_range<std::size_t>& rows) {
                        for (std::size_t row = rows.begin(); row < rows.end(); ++row)
                          marks[row] = stays(cloud.world(row)) ? 1 : 0;
                      });
    report(progress, end, size);
  }
  keep_rows(cloud, marks);
}

}  // namespace

void crop(PointCloud& cloud, const Bounds& box, const Progress& progress) {
  const glm::dvec3 border = border_of(cloud.lattice);
  const Bounds wider{box.min - border, box.max + border};
  keep_places(
      cloud, [&](const glm::dvec3& place) { return wider.contains(place); }, progress);
}

void crop(PointCloud& cloud, std::span<const PlanePolygon> polygons, const Progress& progress) {
  const glm::dvec3 border = border_of(cloud.lattice);
  const PolygonStrips strips(polygons, std::max(border.x, border.y));
  keep_places(
      cloud,
      [&](const glm::dvec3& place) {
        return strips.contains({place.x, place.y});
      },
      progress);
}

}  // namespace alidade
