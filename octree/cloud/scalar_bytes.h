// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "octree/cloud/column_roles.h"

namespace alidade {

/// Reads a value from bytes that need not be aligned; turns them round if the file's order is not the
/// machine's.
template <class Value>
Value value_from(const std::byte* place, std::endian order) {
  std::array<std::byte, sizeof(Value)> bytes;
  std::memcpy(bytes.data(), place, sizeof(Value));
  if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Value>(bytes);
}

/// The cell for the scalar_size(type) bytes at `place`.
inline Cell cell_from(const std::byte* place, ScalarType type, std::endian order) {
  switch (type) {
    case ScalarType::uint8:
      return {static_cast<double>(value_from<std::uint8_t>(place, order)), 0};
    case ScalarType::int8:
      return {static_cast<double>(value_from<std::int8_t>(place, order)), 0};
    case ScalarType::uint16:
      return {static_cast<double>(value_from<std::uint16_t>(place, order)), 0};
    case ScalarType::int16:
      return {static_cast<double>(value_from<std::int16_t>(place, order)), 0};
    case ScalarType::uint32:
      return {static_cast<double>(value_from<std::uint32_t>(place, order)), 0};
    case ScalarType::int32:
      return {static_cast<double>(value_from<std::int32_t>(place, order)), 0};
    case ScalarType::uint64: {
      const auto value = value_from<std::uint64_t>(place, order);
      return {static_cast<double>(value), value};
    }
    case ScalarType::int64: {
      const auto value = value_from<std::int64_t>(place, order);
      return {static_cast<double>(value), static_cast<std::uint64_t>(value)};
    }
    case ScalarType::float32:
      return {static_cast<double>(value_from<float>(place, order)), 0};
    case ScalarType::float64:
      return {value_from<double>(place, order), 0};
    case ScalarType::bytes:
      break;
  }
  return {};
}

}  // namespace alidade
