// SPDX-License-Identifier: MIT
#include "renderer/smooth_normals.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace alidade {
namespace {

// 32 bits: one that says "known", 7 for trust, 12 + 12 for the normal on the octahedron
// (Cigolle et al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 2014).
constexpr double k_trust_steps = 127.0, k_side_steps = 4094.0;  // even, so that upright stays upright

std::uint32_t pack(const LocalPlane& value) {
  const glm::dvec3 n =
      value.normal / (std::fabs(value.normal.x) + std::fabs(value.normal.y) + std::fabs(value.normal.z));
  // The side is free, so the upper half is enough: its square turned by 45 degrees fills the whole range.
  const double sign = n.z < 0.0 ? -1.0 : 1.0;
  const double u = sign * (n.x + n.y), v = sign * (n.x - n.y);
  const auto steps = [](double place) {
    return static_cast<std::uint32_t>((0.5 + 0.5 * place) * k_side_steps + 0.5);
  };
  return 0x80000000u | static_cast<std::uint32_t>(value.trust * k_trust_steps + 0.5) << 24 | steps(u) << 12 |
         steps(v);
}

LocalPlane unpack(std::uint32_t packed) {
  const double u = (packed >> 12 & 0xfffu) / k_side_steps * 2.0 - 1.0,
               v = (packed & 0xfffu) / k_side_steps * 2.0 - 1.0;
  const double x = 0.5 * (u + v), y = 0.5 * (u - v);
  return {glm::normalize(glm::dvec3(x, y, 1.0 - std::fabs(x) - std::fabs(y))),
          (packed >> 24 & 0x7fu) / k_trust_steps};
}

}  // namespace

SmoothNormals::SmoothNormals(const Octree& octree) : octree_(&octree), kept_(octree.size()) {}

LocalPlane SmoothNormals::at(std::uint64_t point_id, const glm::dvec3& position, double reach) const {
  std::atomic<std::uint32_t>& kept = kept_[point_id];
  std::uint32_t packed = kept.load(std::memory_order_relaxed);
  if (packed == 0) {
    // Two threads may both do this; they get the same.
    packed = pack(local_plane(*octree_, position, reach));
    kept.store(packed, std::memory_order_relaxed);
  }
  return unpack(packed);
}

}  // namespace alidade
