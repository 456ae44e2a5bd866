// SPDX-License-Identifier: MIT
#include "cloud/cloud_reader.h"

#include <algorithm>
#include <glm/common.hpp>

#include "cloud/rows.h"

namespace alidade {
namespace {

std::uint64_t bytes_per_point(PointCloud& cloud, AttributeSet attributes) {
  std::uint64_t bytes = sizeof(LatticePosition);
  for_each_column(cloud, [&](Attribute attribute, const auto& column) {
    if (attributes.contains(attribute)) bytes += sizeof column[0];
  });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    bytes += static_cast<std::uint64_t>(dimension.byte_count);
  return bytes;
}

}  // namespace

std::size_t room_in_piece(PointCloud& cloud, AttributeSet coming, std::uint64_t wanted,
                          const CloudPieces& pieces) {
  if (!pieces.take) return static_cast<std::size_t>(wanted);
  const std::uint64_t bytes = bytes_per_point(cloud, cloud.attributes() | coming) + pieces.bytes_beside;
  const std::uint64_t most = std::clamp<std::uint64_t>(pieces.most_bytes / bytes, 1, UINT32_MAX);
  if (cloud.size() >= most) pieces.take(cloud);
  return static_cast<std::size_t>(std::min(wanted, most - cloud.size()));
}

void RowsToFill::make_rows() {
  const std::size_t count = room_in_piece(cloud_, filled_, left_, pieces_);
  next_ = cloud_.size();
  left_ -= count;
  append_rows(cloud_, filled_, count);
}

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
