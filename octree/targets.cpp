// SPDX-License-Identifier: MIT
#include "octree/path.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/unit_direction.h"

namespace alidade {

Path make_path(const std::vector<glm::dvec3>& vertices, double t_min, double t_max) {
  if (std::isnan(t_min) || std::isnan(t_max))
    throw Error({.problem = "limit of the path's interval is not a number"});
  Path path{.vertices = {}, .vertex_t = {}, .t_min = t_min, .t_max = t_max};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const glm::dvec3& vertex = vertices[i];
    if (!std::isfinite(vertex.x) || !std::isfinite(vertex.y) || !std::isfinite(vertex.z))
      throw Error({.problem = fmt::format("vertex {} of a path is not finite", i)});
    if (path.vertices.empty()) {
      path.vertex_t.push_back(0.0);
    } else {
      const double length = length_of(vertex - path.vertices.back());
      if (length == 0.0) continue;
      path.vertex_t.push_back(path.vertex_t.back() + length);
    }
    path.vertices.push_back(vertex);
  }
  if (path.vertices.size() < 2) {
    throw Error({.problem = "path has too few different vertices",
                 .expected = "at least 2",
                 .found = fmt::format("{}", path.vertices.size())});
  }
  if (!std::isfinite(path.vertex_t.back())) throw Error({.problem = "path is too long for a number"});
  return path;
}

}  // namespace alidade
