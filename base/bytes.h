// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "base/byte_order.h"
#include "base/error.h"

namespace alidade {

/// The head or a record of a little-endian file: gives fields, and complains about them by their byte. Keeps
/// references to bytes and file name.
class HeaderFields {
 public:
  /// file_place: where `bytes` begin in the file.
  HeaderFields(std::span<const std::byte> bytes, const std::string& file_name, std::uint64_t file_place = 0)
      : bytes_(bytes), file_(file_name), file_place_(file_place) {}

  /// Requires that the field lies within the bytes.
  template <class T>
  T get(std::size_t place) const {
    return load<T>(bytes_.data() + place);
  }
  /// Throws an Error about the field at `place` unless what is asked holds.
  template <class Found>
  void require(bool holds, std::size_t place, std::string problem, std::string expected,
               const Found& found) const {
    if (holds) return;
    throw Error({.file = file_,
                 .place = fmt::format("byte {}", file_place_ + place),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = fmt::format("{}", found)});
  }

 private:
  std::span<const std::byte> bytes_;
  const std::string& file_;
  std::uint64_t file_place_;
};

}  // namespace alidade
