// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>

#include "visibility/raster/ground.h"

namespace alidade {

/// Shading of the ground by a light in the north-west, 45 degrees high: what makes a map of heights look like
/// land. Heights are drawn up where the land is flat.
class Relief {
 public:
  /// `step`: slopes are taken over twice this length, about a pixel of the picture. Cost: about 10 000
  /// heights.
  Relief(const Ground& ground, double step);

  /// Brightness of a place: 1 where it is level, from 0 in the shade to about 1.4 towards the light; 1 where
  /// there is no ground around it.
  double light(const glm::dvec2& place) const;

 private:
  glm::dvec2 slope(const glm::dvec2& place) const;

  const Ground& ground_;
  double step_;
  double exaggeration_ = 1.0;
};

}  // namespace alidade
