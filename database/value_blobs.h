// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "octree/cloud/attribute_columns.h"

namespace alidade {

/// Values of one blob (StoredColumn), by row of the cloud.
struct ValueBlob {
  const std::byte* values;
  std::size_t size;  ///< bytes per point
};

/// All blobs but the first, which holds ids; in the order of stored_columns(). The columns must outlive them.
std::vector<ValueBlob> value_blobs(const AttributeColumns& columns);

}  // namespace alidade
