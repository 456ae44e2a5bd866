// SPDX-License-Identifier: MIT
#include "cloud/append_rows.h"

#include <tbb/parallel_for_each.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

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
  // Touching the memory of so many rows takes as long as unpacking some of them.
  constexpr std::size_t k_rows_for_threads = 1 << 16;
  const std::size_t size = cloud.size() + count;
  const std::size_t room = std::max(size, cloud.positions.capacity());
  std::vector<std::function<void()>> columns;
  const auto grow = [&](auto& column, Attribute attribute) {
    if (column.empty() && !filled.contains(attribute)) return;
    columns.emplace_back([&column, size, room] {
      // A column that starts now takes all the room the positions have, so that it is not moved either.
      if (column.empty()) column.reserve(room);
      column.resize(size);
    });
  };
  columns.emplace_back([&cloud, size] { cloud.positions.resize(size, LatticePosition(0)); });
  grow(cloud.gps_times, Attribute::gps_time);
  grow(cloud.normals, Attribute::normal);
  grow(cloud.colors, Attribute::color);
  grow(cloud.scan_angles, Attribute::scan_angle);
  grow(cloud.near_infrared, Attribute::near_infrared);
  grow(cloud.intensities, Attribute::intensity);
  grow(cloud.returns, Attribute::returns);
  grow(cloud.point_source_ids, Attribute::point_source_id);
  grow(cloud.classifications, Attribute::classification);
  grow(cloud.flags, Attribute::flags);
  grow(cloud.user_data, Attribute::user_data);
  for (ExtraDimension& dimension : cloud.extra_dimensions) {
    columns.emplace_back([&dimension, size] {
      dimension.values.resize(size * static_cast<std::size_t>(dimension.byte_count));
    });
  }
  if (count < k_rows_for_threads) {
    for (const auto& extend : columns) extend();
  } else {
    tbb::parallel_for_each(columns, [](const auto& extend) { extend(); });
  }
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
