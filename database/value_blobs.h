// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Values of one blob (StoredColumn), by row of the cloud.
struct ValueBlob {
  const std::byte* values = nullptr;
  std::size_t size = 0;    ///< bytes per point
  std::size_t number = 0;  ///< of the attribute's bit; of extra dimensions theirs, behind all bits

  bool is(Attribute attribute) const { return number == number_of(attribute); }
  static constexpr std::size_t number_of(Attribute attribute) {
    return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(attribute)));
  }
};

/// All blobs but the first, which holds ids; in the order of stored_columns(). The columns must outlive them.
std::vector<ValueBlob> value_blobs(const AttributeColumns& columns);

}  // namespace alidade
