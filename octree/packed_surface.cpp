// SPDX-License-Identifier: MIT
#include "octree/packed_surface.h"

#include <algorithm>

#include "octree/point_surface.h"

namespace alidade::packed_surface {
namespace {

/// The nearest length.
std::uint32_t nearest_length(double length) {
  const auto above = std::ranges::lower_bound(k_lengths, length);
  if (above == k_lengths.begin()) return 0;
  if (above == k_lengths.end()) return k_length_mask;
  const auto index = static_cast<std::uint32_t>(above - k_lengths.begin());
  return length - k_lengths[index - 1] < k_lengths[index] - length ? index - 1 : index;
}

/// The least length that is not smaller, or the greatest.
std::uint32_t length_above(double length) {
  const auto above = std::ranges::lower_bound(k_lengths, length);
  return above == k_lengths.end() ? k_length_mask : static_cast<std::uint32_t>(above - k_lengths.begin());
}

}  // namespace

std::uint32_t pack(const PointSurface& surface, double unit) {
  if (!surface.exists) return 0;
  const glm::uvec2 normal = pack_normal(surface.normal, k_side_steps);
  // Packing keeps the upper one of the two normals.
  const bool turned = surface.normal.z < 0.0;
  const bool below = (surface.height < 0.0) != turned;
  return k_exists | normal.x << k_first_side | normal.y << k_second_side | (below ? k_below : 0u) |
         nearest_length(std::fabs(surface.height) / unit) << k_height |
         length_above(surface.thickness / unit);
}

}  // namespace alidade::packed_surface
