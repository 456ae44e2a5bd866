// SPDX-License-Identifier: MIT
#include "database/cloud_column.h"

#include <span>
#include <string>
#include <utility>

namespace alidade::database {

std::vector<CloudColumn> cloud_columns(const PointCloud& cloud) {
  std::vector<CloudColumn> columns;
  for (int axis = 0; axis < 3; ++axis) {
    CloudColumn& column = columns.emplace_back();
    column.like.name = "xyz"[axis];
    column.axis = axis;
  }
  // By the number that stored_columns() gives a blob.
  std::vector<std::span<const std::byte>> blobs(1);
  for_each_column(cloud, [&](Attribute, const auto& column) {
    if (!column.empty()) blobs.push_back(std::as_bytes(std::span(column)));
  });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    blobs.push_back(std::as_bytes(std::span(dimension.values)));
  for (StoredColumn& stored : stored_columns(cloud)) {
    if (stored.blob == 0) continue;
    CloudColumn& column = columns.emplace_back();
    column.values = blobs[static_cast<std::size_t>(stored.blob)].data() + stored.byte;
    column.like = std::move(stored);
  }
  return columns;
}

}  // namespace alidade::database
