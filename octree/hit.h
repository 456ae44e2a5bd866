// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace alidade {

/// One point that answers a ray query. A miss is an empty std::optional, never a special id.
struct Hit {
  std::uint64_t point_id = 0;  ///< row of the cloud
  glm::dvec3 position{0.0};    ///< of the point, world coordinates
  double t = 0.0;              ///< place of the point's projection on the ray, metres
  double distance = 0.0;       ///< of the point to the ray's line, metres
  double entry = 0.0;  ///< where the ray enters the sphere of the query's radius around the point, metres

  bool operator==(const Hit&) const = default;
};

}  // namespace alidade
