// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>

namespace alidade {

// LAS and most other binary formats are little endian, and so is every machine Alidade runs on.
static_assert(std::endian::native == std::endian::little, "values are copied as they stand in memory");

/// The little-endian value of type T at any address, aligned or not.
template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

/// Puts a value at any address as little-endian bytes.
template <class T>
void store(std::byte* at, const T& value) {
  std::memcpy(at, &value, sizeof(T));
}

}  // namespace alidade
