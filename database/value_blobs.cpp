// SPDX-License-Identifier: MIT
#include "database/value_blobs.h"

namespace alidade {

std::vector<ValueBlob> value_blobs(const AttributeColumns& columns) {
  std::vector<ValueBlob> blobs;
  for_each_column(columns, columns, [&](Attribute, const auto& column, const auto&) {
    if (!column.empty())
      blobs.push_back({reinterpret_cast<const std::byte*>(column.data()), sizeof column.front()});
  });
  for (const ExtraColumn& column : columns.extra_dimensions) {
    blobs.push_back({reinterpret_cast<const std::byte*>(column.values.data()),
                     static_cast<std::size_t>(column.description.byte_count)});
  }
  return blobs;
}

}  // namespace alidade
