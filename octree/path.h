// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace alidade {

/// A trajectory: straight segments from vertex to vertex. Places on it are told by t, the length of the way
/// from the first vertex, in metres.
struct Path {
  std::vector<glm::dvec3> vertices;                         ///< two or more; consecutive ones differ
  std::vector<double> vertex_t;                             ///< t of every vertex, made by make_path
  double t_min = -std::numeric_limits<double>::infinity();  ///< closed interval on t
  double t_max = std::numeric_limits<double>::infinity();
};

/// The entrance for paths from outside. Repeated vertices in a row are joined to one. Errors: a coordinate
/// that is not finite (the message tells the vertex), fewer than two different vertices, limits NaN.
Path make_path(const std::vector<glm::dvec3>& vertices,
               double t_min = -std::numeric_limits<double>::infinity(),
               double t_max = std::numeric_limits<double>::infinity());

}  // namespace alidade
