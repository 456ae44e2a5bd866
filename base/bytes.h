// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"

namespace alidade {

// LAS and most other binary formats are little endian, and so is every machine Alidade runs on.
static_assert(std::endian::native == std::endian::little, "values are copied byte by byte");

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

/// The head or a record of a little-endian file. Reads fields; errors name the byte of the field. Keeps
/// references to bytes and file name.
class HeaderFields {
 public:
  /// file_offset: where `bytes` begin in the file.
  HeaderFields(std::span<const std::byte> bytes, const std::string& file_name, std::uint64_t file_offset = 0)
      : bytes_(bytes), file_(file_name), file_offset_(file_offset) {}

  /// Requires that the field lies within the bytes.
  template <class T>
  T get(std::size_t offset) const {
    return load<T>(bytes_.data() + offset);
  }

  /// Throws an Error about the field at `offset` unless `holds`.
  template <class Found>
  void require(bool holds, std::size_t offset, std::string problem, std::string expected,
               const Found& found) const {
    if (holds) return;
    fail_at_byte(file_, file_offset_ + offset, std::move(problem), std::move(expected),
                 fmt::format("{}", found));
  }

 private:
  std::span<const std::byte> bytes_;
  const std::string& file_;
  std::uint64_t file_offset_;
};

}  // namespace alidade
