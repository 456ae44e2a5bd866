// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "cloud/point_cloud.h"
#include "tests/support/random.h"

namespace alidade::test {

/// Random positions in and around a cloud, and random lengths between nothing and more than the cloud.
class Positions {
 public:
  Positions(const PointCloud& cloud, Random& random)
      : cloud_(cloud), random_(random), bounds_(cloud.bounds()) {
    if (bounds_.empty()) bounds_.grow(glm::dvec3(0.0));
    const glm::dvec3 size = bounds_.size();
    diagonal_ = std::max(std::sqrt(size.x * size.x + size.y * size.y + size.z * size.z), 1.0);
    spacing_ = diagonal_ / std::cbrt(static_cast<double>(std::max<std::size_t>(cloud.size(), 1)));
  }

  const Bounds& bounds() const { return bounds_; }
  double diagonal() const { return diagonal_; }
  double spacing() const { return spacing_; }

  /// One of the points.
  glm::dvec3 point() const {
    return cloud_.size() ? cloud_.world(random_.below(cloud_.size())) : bounds_.center();
  }
  /// Anywhere in the box around the points.
  glm::dvec3 inside() const {
    return bounds_.min + bounds_.size() * glm::dvec3(random_.unit(), random_.unit(), random_.unit());
  }
  /// A point, beside a point, inside or far outside of the box.
  glm::dvec3 anywhere() const {
    switch (random_.below(5)) {
      case 0:
        return point();
      case 1:
        return point() + spacing_ * random_.in_cube();
      case 2:
        return bounds_.center() + 1e6 * random_.in_cube();
      case 3:
        return bounds_.center() + 2.0 * diagonal_ * random_.in_cube();
      default:
        return inside();
    }
  }
  /// From nothing to more than the cloud.
  double length() const {
    const double lengths[] = {0.0,      1e-9,          1e-4, 0.01 * spacing_, 0.1 * spacing_, 0.5 * spacing_,
                              spacing_, 10 * diagonal_};
    return lengths[random_.below(std::size(lengths))];
  }

 private:
  const PointCloud& cloud_;
  Random& random_;
  Bounds bounds_;
  double diagonal_ = 0.0;
  double spacing_ = 0.0;
};

}  // namespace alidade::test
