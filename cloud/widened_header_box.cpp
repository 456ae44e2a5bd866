// SPDX-License-Identifier: MIT
#include <algorithm>
#include <glm/common.hpp>

#include "cloud/cloud_reader.h"

namespace alidade {

std::optional<Bounds> widened_header_box(const Bounds& stated, const Lattice& lattice) {
  constexpr double k_steps = 8, k_share = 1e-5;
  if (stated.empty() || !to_lattice(lattice, stated.min) || !to_lattice(lattice, stated.max))
    return std::nullopt;
  const glm::dvec3 sides = stated.size();
  const double longest = std::max({sides.x, sides.y, sides.z});
  if (longest == 0.0) return std::nullopt;
  const glm::dvec3 margin = glm::max(k_steps * lattice.scale, glm::dvec3(k_share * longest));
  return Bounds{stated.min - margin, stated.max + margin};
}

}  // namespace alidade
