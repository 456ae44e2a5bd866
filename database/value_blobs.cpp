// SPDX-License-Identifier: MIT
#include "database/value_blobs.h"

namespace alidade {

std::vector<ValueBlob> value_blobs(const AttributeColumns& columns) {
  std::vector<ValueBlob> blobs;
  for_each_column(columns, columns, [&](Attribute attribute, const auto& column, const auto&) {
    if (!column.empty())
      blobs.push_back({reinterpret_cast<const std::byte*>(column.data()), sizeof column.front(),
                       ValueBlob::number_of(attribute)});
  });
  std::size_t number = ValueBlob::number_of(Attribute::extra_dimensions);
  for (const ExtraColumn& column : columns.extra_dimensions) {
    blobs.push_back({reinterpret_cast<const std::byte*>(column.values.data()),
                     static_cast<std::size_t>(column.description.byte_count), number++});
  }
  return blobs;
}

}  // namespace alidade
