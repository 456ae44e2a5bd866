// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "extensions/parquet/encodings.h"

namespace alidade::database {

/// Writes structures in the compact protocol of Apache Thrift, which Parquet uses for its metadata. Fields of
/// a structure must be written in ascending order of ids.
class ThriftWriter {
 public:
  enum class Kind : std::uint8_t {
    yes = 1,
    no = 2,
    byte = 3,
    int32 = 5,
    int64 = 6,
    binary = 8,
    list = 9,
    structure = 12
  };

  void boolean(int id, bool value) { begin_field(id, value ? Kind::yes : Kind::no); }
  void byte(int id, std::int8_t value) {
    begin_field(id, Kind::byte);
    bytes_.push_back(static_cast<std::byte>(value));
  }
  void int32(int id, std::int32_t value) {
    begin_field(id, Kind::int32);
    append_varint(zigzag(value), bytes_);
  }
  void int64(int id, std::int64_t value) {
    begin_field(id, Kind::int64);
    append_varint(zigzag(value), bytes_);
  }
  void binary(int id, std::span<const std::byte> value) {
    begin_field(id, Kind::binary);
    put(value);
  }
  void text(int id, std::string_view value) { binary(id, std::as_bytes(std::span(value))); }

  /// A structure as a field; `fill()` writes its fields.
  template <class Fill>
  void structure(int id, const Fill& fill) {
    begin_field(id, Kind::structure);
    structure(fill);
  }

  /// A structure that is not a field: the outermost one, or an element of a list.
  template <class Fill>
  void structure(const Fill& fill) {
    const int outer = std::exchange(last_id_, 0);
    fill();
    bytes_.push_back(std::byte{0});
    last_id_ = outer;
  }

  /// Begins a list; `count` elements of that kind must follow.
  void list(int id, Kind kind, std::size_t count) {
    begin_field(id, Kind::list);
    constexpr std::size_t k_short = 15;
    const auto low = static_cast<unsigned>(kind);
    if (count < k_short) {
      bytes_.push_back(static_cast<std::byte>(count << 4 | low));
    } else {
      bytes_.push_back(static_cast<std::byte>(0xf0 | low));
      append_varint(count, bytes_);
    }
  }
  void element(std::int32_t value) { append_varint(zigzag(value), bytes_); }
  void element(std::string_view value) { put(std::as_bytes(std::span(value))); }
  /// Adds elements that another writer wrote.
  void elements(const Bytes& written) { bytes_.insert(bytes_.end(), written.begin(), written.end()); }

  const Bytes& bytes() const { return bytes_; }

 private:
  void begin_field(int id, Kind kind) {
    const auto low = static_cast<unsigned>(kind);
    const int step = id - std::exchange(last_id_, id);
    constexpr int k_most_step = 15;
    bytes_.push_back(
        static_cast<std::byte>((step <= k_most_step ? static_cast<unsigned>(step) << 4 : 0u) | low));
    if (step > k_most_step) append_varint(zigzag(id), bytes_);
  }
  void put(std::span<const std::byte> value) {
    append_varint(value.size(), bytes_);
    bytes_.insert(bytes_.end(), value.begin(), value.end());
  }

  Bytes bytes_;
  int last_id_ = 0;
};

}  // namespace alidade::database
