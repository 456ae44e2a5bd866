// SPDX-License-Identifier: MIT
#include "cloud/reorder_attributes.h"

#include <cassert>
#include <cstring>

namespace alidade {
namespace {

template <class Value>
void reorder(std::vector<Value>& column, std::span<const std::uint32_t> order) {
  if (column.empty()) return;
  assert(column.size() == order.size());
  std::vector<Value> ordered;
  ordered.reserve(order.size());
  for (const std::uint32_t row : order) ordered.push_back(column[row]);
  column.swap(ordered);
}

void reorder(ExtraDimension& dimension, std::span<const std::uint32_t> order) {
  const auto width = static_cast<std::size_t>(dimension.byte_count);
  assert(dimension.values.size() == order.size() * width);
  std::vector<std::uint8_t> ordered(dimension.values.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    std::memcpy(ordered.data() + i * width, dimension.values.data() + order[i] * width, width);
  dimension.values.swap(ordered);
}

}  // namespace

void reorder_attributes(PointCloud& cloud, std::span<const std::uint32_t> order) {
  reorder(cloud.colors, order);
  reorder(cloud.near_infrared, order);
  reorder(cloud.intensities, order);
  reorder(cloud.classifications, order);
  reorder(cloud.returns, order);
  reorder(cloud.flags, order);
  reorder(cloud.scan_angles, order);
  reorder(cloud.user_data, order);
  reorder(cloud.point_source_ids, order);
  reorder(cloud.gps_times, order);
  reorder(cloud.normals, order);
  for (ExtraDimension& dimension : cloud.extra_dimensions) reorder(dimension, order);
}

}  // namespace alidade
