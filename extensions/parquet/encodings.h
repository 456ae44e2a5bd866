// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Parquet's encodings of integers. Source: the specification of the Apache Parquet format, "Encodings".

namespace alidade::database {

using Bytes = std::vector<std::byte>;

/// Appends the bytes of a value, little endian.
template <class Value>
void append_value(const Value& value, Bytes& bytes) {
  const auto some = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), some.begin(), some.end());
}

/// Seven bits per byte, lowest first; all bytes but the last have the highest bit set (ULEB128).
void append_varint(std::uint64_t number, Bytes& bytes);

/// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
constexpr std::uint64_t zigzag(std::int64_t number) {
  return (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63);
}

/// Packs numbers of `width` bits each, 0 to 64, from the lowest bit of the first byte on. Zeros fill the last
/// byte. Requires that no number has more bits.
template <class Unsigned>
void append_packed(std::span<const Unsigned> numbers, int width, Bytes& bytes) {
  if (width == 0) return;
  std::uint64_t buffer = 0;
  int used = 0;
  for (const Unsigned number : numbers) {
    const std::uint64_t bits = number;
    buffer |= bits << used;
    used += width;
    if (used < 64) continue;
    append_value(buffer, bytes);
    used -= 64;
    buffer = used == 0 ? 0 : bits >> (width - used);
  }
  for (; used > 0; used -= 8, buffer >>= 8) bytes.push_back(static_cast<std::byte>(buffer & 0xff));
}

/// The hybrid of runs and packed groups of eight (RLE), without its length. `width`:
/// bits per number, 1 to 32.
void append_runs(std::span<const std::uint32_t> numbers, int width, Bytes& bytes);

/// DELTA_BINARY_PACKED, in blocks of 128 numbers of 4 or 8 bytes: signed ones as their bits.
template <class Unsigned>
void append_deltas(std::span<const Unsigned> numbers, Bytes& bytes);
extern template void append_deltas(std::span<const std::uint32_t> numbers, Bytes& bytes);
extern template void append_deltas(std::span<const std::uint64_t> numbers, Bytes& bytes);

}  // namespace alidade::database
