// SPDX-License-Identifier: MIT
#include "database/cloud_column.h"

#include <span>
#include <string>
#include <type_traits>
#include <utility>

namespace alidade::database {

std::vector<CloudColumn> cloud_columns(const PointColumns& cloud) {
  std::vector<CloudColumn> columns;
  for (int axis = 0; axis < 3; ++axis) {
    CloudColumn& column = columns.emplace_back();
    column.like.name = "xyz"[axis];
    column.axis = axis;
  }
  // By the number that stored_columns() gives a blob.
  std::vector<std::span<const std::byte>> blobs(1);
  for_each_column(cloud.attributes, [&](Attribute, const auto& column) {
    if (column.empty()) return;
    if constexpr (std::is_same_v<decltype(column), const ColorColumn&>)
      blobs.push_back(std::as_bytes(column.deep()));
    else
      blobs.push_back(std::as_bytes(column));
  });
  std::vector<ExtraDimension> dimensions;
  for (const ExtraColumn& column : cloud.attributes.extra_dimensions) {
    blobs.push_back(std::as_bytes(column.values));
    dimensions.push_back(column.description);
  }
  for (StoredColumn& stored : stored_columns(cloud.attributes.attributes(), std::move(dimensions))) {
    if (stored.blob == 0) continue;
    CloudColumn& column = columns.emplace_back();
    column.values = blobs[static_cast<std::size_t>(stored.blob)].data() + stored.byte;
    column.like = std::move(stored);
  }
  return columns;
}

}  // namespace alidade::database
