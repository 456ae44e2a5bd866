// SPDX-License-Identifier: MIT
#include "renderer/smooth_normals.h"

#include "octree/point_surface.h"

namespace alidade {
namespace {

// 32 bits: one that says "known", 7 for trust, 12 + 12 for the normal.
constexpr double k_trust_steps = 127.0, k_side_steps = 4094.0;

std::uint32_t pack(const LocalPlane& value) {
  const glm::uvec2 normal = pack_normal(value.normal, k_side_steps);
  return 0x80000000u | static_cast<std::uint32_t>(value.trust * k_trust_steps + 0.5) << 24 | normal.x << 12 |
         normal.y;
}

LocalPlane unpack(std::uint32_t packed) {
  return {.normal = unpack_normal({packed >> 12 & 0xfffu, packed & 0xfffu}, k_side_steps),
          .trust = (packed >> 24 & 0x7fu) / k_trust_steps};
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
