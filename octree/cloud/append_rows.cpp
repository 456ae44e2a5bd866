// SPDX-License-Identifier: MIT
#include "octree/cloud/append_rows.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace alidade {

bool same_meaning(const ExtraDimension& a, const ExtraDimension& b) {
  // Bits are compared, so that a NaN from a damaged file equals itself.
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  return a.name == b.name && a.type == b.type && a.byte_count == b.byte_count && a.has_scale == b.has_scale &&
         a.has_offset == b.has_offset && bits(a.scale) == bits(b.scale) && bits(a.offset) == bits(b.offset) &&
         a.no_data == b.no_data;
}

ExtraDimension description_of(const ExtraDimension& dimension) {
  return {.name = dimension.name,
          .description = dimension.description,
          .type = dimension.type,
          .byte_count = dimension.byte_count,
          .scale = dimension.scale,
          .offset = dimension.offset,
          .has_scale = dimension.has_scale,
          .has_offset = dimension.has_offset,
          .no_data = dimension.no_data,
          .values = {}};
}

void append_rows(PointCloud& cloud, AttributeSet filled, std::size_t count) {
  const std::size_t size = cloud.size() + count;
  const auto grow = [&](auto& column, Attribute attribute) {
    if (column.empty() && !filled.contains(attribute)) return;
    // A column that starts now takes all the room the positions have, so that it is not moved either.
    if (column.empty()) column.reserve(std::max(size, cloud.positions.capacity()));
    column.resize(size);
  };
  grow(cloud.colors, Attribute::color);
  grow(cloud.near_infrared, Attribute::near_infrared);
  grow(cloud.intensities, Attribute::intensity);
  grow(cloud.classifications, Attribute::classification);
  grow(cloud.returns, Attribute::returns);
  grow(cloud.flags, Attribute::flags);
  grow(cloud.scan_angles, Attribute::scan_angle);
  grow(cloud.user_data, Attribute::user_data);
  grow(cloud.point_source_ids, Attribute::point_source_id);
  grow(cloud.gps_times, Attribute::gps_time);
  grow(cloud.normals, Attribute::normal);
  for (ExtraDimension& dimension : cloud.extra_dimensions) {
    dimension.values.resize(size * static_cast<std::size_t>(dimension.byte_count));
  }
  cloud.positions.resize(size, LatticePosition(0));
}

std::size_t find_extra_dimension(PointCloud& cloud, const ExtraDimension& like, std::size_t occurrence) {
  for (std::size_t i = 0; i < cloud.extra_dimensions.size(); ++i) {
    if (same_meaning(cloud.extra_dimensions[i], like) && occurrence-- == 0) return i;
  }
  ExtraDimension& added = cloud.extra_dimensions.emplace_back(description_of(like));
  const std::size_t bytes = static_cast<std::size_t>(like.byte_count);
  added.values.reserve(cloud.positions.capacity() * bytes);
  added.values.resize(cloud.size() * bytes);
  return cloud.extra_dimensions.size() - 1;
}

}  // namespace alidade
