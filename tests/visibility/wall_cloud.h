// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include "octree/build.h"
#include "tests/support/point_families.h"
#include "visibility/sight_line.h"

namespace alidade::test {

using namespace visibility;

/// Points on rectangles, to be built into a cloud.
class WallCloud {
 public:
  /// A rectangle from `corner` along two sides, with points every `spacing` metres, both edges included.
  WallCloud& add(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, double spacing) {
    const double u_length = std::sqrt(u.x * u.x + u.y * u.y + u.z * u.z);
    const double v_length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    const int columns = static_cast<int>(std::lround(u_length / spacing));
    const int rows = static_cast<int>(std::lround(v_length / spacing));
    for (int row = 0; row <= rows; ++row) {
      for (int column = 0; column <= columns; ++column)
        positions_.push_back(corner + u * (static_cast<double>(column) / columns) +
                             v * (static_cast<double>(row) / rows));
    }
    return *this;
  }
  WallCloud& add(const glm::dvec3& point) {
    positions_.push_back(point);
    return *this;
  }

  const std::vector<glm::dvec3>& positions() const { return positions_; }
  Octree octree() const { return build(make_cloud(positions_, {glm::dvec3(1e-4), glm::dvec3(0.0)})); }
  Occluders occluders(const OccluderOptions& options = {}) const { return Occluders(octree(), options); }

 private:
  std::vector<glm::dvec3> positions_;
};

}  // namespace alidade::test
