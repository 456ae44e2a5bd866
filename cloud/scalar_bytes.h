// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/bytes.h"
#include "cloud/column_roles.h"

namespace alidade {

/// The value at any address, aligned or not; turned round if the file's order is not the machine's.
template <class Value>
Value load(const std::byte* at, std::endian order) {
  if (order == std::endian::native) return load<Value>(at);
  std::array<std::byte, sizeof(Value)> bytes;
  std::reverse_copy(at, at + sizeof(Value), bytes.begin());
  return std::bit_cast<Value>(bytes);
}

/// The cell for the scalar_size(type) bytes at `place`.
inline Cell cell_from(const std::byte* place, ScalarType type, std::endian order) {
  switch (type) {
    case ScalarType::uint8:
      return {static_cast<double>(load<std::uint8_t>(place, order)), 0};
    case ScalarType::int8:
      return {static_cast<double>(load<std::int8_t>(place, order)), 0};
    case ScalarType::uint16:
      return {static_cast<double>(load<std::uint16_t>(place, order)), 0};
    case ScalarType::int16:
      return {static_cast<double>(load<std::int16_t>(place, order)), 0};
    case ScalarType::uint32:
      return {static_cast<double>(load<std::uint32_t>(place, order)), 0};
    case ScalarType::int32:
      return {static_cast<double>(load<std::int32_t>(place, order)), 0};
    case ScalarType::uint64: {
      const auto value = load<std::uint64_t>(place, order);
      return {static_cast<double>(value), value};
    }
    case ScalarType::int64: {
      const auto value = load<std::int64_t>(place, order);
      return {static_cast<double>(value), static_cast<std::uint64_t>(value)};
    }
    case ScalarType::float32:
      return {static_cast<double>(load<float>(place, order)), 0};
    case ScalarType::float64:
      return {load<double>(place, order), 0};
    case ScalarType::bytes:
      break;
  }
  return {};
}

}  // namespace alidade
