// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "octree/cloud/byte_order.h"
#include "octree/error.h"

namespace alidade {

/// The first bytes of one of our own little-endian files: gives fields, and complains about them by their
/// byte. Keeps references to bytes and file name.
class HeaderFields {
 public:
  HeaderFields(std::span<const std::byte> bytes, const std::string& file_name)
      : bytes_(bytes), file_(file_name) {}

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
                 .place = fmt::format("byte {}", place),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = fmt::format("{}", found)});
  }

 private:
  std::span<const std::byte> bytes_;
  const std::string& file_;
};

}  // namespace alidade
