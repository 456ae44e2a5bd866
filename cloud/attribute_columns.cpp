// SPDX-License-Identifier: MIT
#include "cloud/attribute_columns.h"

#include "cloud/append_rows.h"

namespace alidade {

AttributeSet AttributeColumns::attributes() const {
  AttributeSet set;
  for_each_column(*this, *this, [&](Attribute attribute, const auto& column, const auto&) {
    if (!column.empty()) set = set | attribute;
  });
  return extra_dimensions.empty() ? set : set | Attribute::extra_dimensions;
}

AttributeColumns columns_of(const PointCloud& cloud) {
  AttributeColumns columns;
  for_each_column(columns, cloud, [](Attribute, auto& view, const auto& column) { view = column; });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    columns.extra_dimensions.push_back({description_of(dimension), dimension.values});
  return columns;
}

}  // namespace alidade
