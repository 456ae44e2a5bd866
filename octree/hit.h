// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

// Points that answer a query. A miss is an empty std::optional or list, never a special id.

namespace alidade {

/// A point that answers a ray or cone query.
struct Hit {
  std::uint64_t point_id = 0;  ///< row of the cloud
  glm::dvec3 position{0.0};    ///< of the point, world coordinates
  double t = 0.0;              ///< place of the point's projection on the ray, metres
  double distance = 0.0;       ///< of the point to the ray's line, metres
  /// Where the ray enters the sphere around the point whose radius is the query's (for a cone: the limit at
  /// t), metres; -infinity if the radius is infinite.
  double entry = 0.0;

  bool operator==(const Hit&) const = default;
};

/// A point that answers a point, box or half-space query.
struct PointHit {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  /// To the point asked for; of half-spaces: signed distance to the first plane; of boxes: 0. Metres.
  double distance = 0.0;

  bool operator==(const PointHit&) const = default;
};

/// A point that answers a path query.
struct PathHit {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  /// The nearest one, from vertex `segment` to the next; of equally near ones the first.
  std::size_t segment = 0;
  double t = 0.0;         ///< place of the nearest point of the path, metres from its first vertex
  double distance = 0.0;  ///< to the nearest point of the path, metres

  bool operator==(const PathHit&) const = default;
};

}  // namespace alidade
