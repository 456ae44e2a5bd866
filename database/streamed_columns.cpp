// SPDX-License-Identifier: MIT
#include "database/streamed_columns.h"

#include "cloud/rows.h"

namespace alidade {

std::vector<StoredColumn> streamed_columns(const PiecewiseCloud& whole, const PointStream& points) {
  PointCloud cloud;
  for (const ExtraDimension& dimension : whole.rest.extra_dimensions)
    cloud.extra_dimensions.push_back(description_of(dimension));
  AttributeSet attributes;
  for (const ValueBlob& blob : points.blobs()) {
    if (blob.number < ValueBlob::number_of(Attribute::extra_dimensions))
      attributes.bits |= std::uint32_t{1} << blob.number;
  }
  append_rows(cloud, attributes, 1);
  return stored_columns(cloud);
}

}  // namespace alidade
