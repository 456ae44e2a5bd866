// SPDX-License-Identifier: MIT
#include "extensions/parquet/encodings.h"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

namespace alidade::database {
namespace {

/// Numbers of a packed group, and the shortest run that is worth its header.
constexpr std::size_t k_group = 8;

void append_literals(std::span<const std::uint32_t> numbers, int width, Bytes& bytes) {
  if (numbers.empty()) return;
  const std::size_t groups = (numbers.size() + k_group - 1) / k_group;
  append_varint(groups << 1 | 1, bytes);
  const std::size_t end = bytes.size() + groups * static_cast<std::size_t>(width);
  append_packed(numbers, width, bytes);
  bytes.resize(end);
}

}  // namespace

void append_varint(std::uint64_t number, Bytes& bytes) {
  for (; number >= 0x80; number >>= 7) bytes.push_back(static_cast<std::byte>((number & 0x7f) | 0x80));
  bytes.push_back(static_cast<std::byte>(number));
}

void append_runs(std::span<const std::uint32_t> numbers, int width, Bytes& bytes) {
  std::size_t literals = 0;  // where they begin
  for (std::size_t at = 0; at < numbers.size();) {
    std::size_t end = at + 1;
    while (end < numbers.size() && numbers[end] == numbers[at]) ++end;
    if (end - at < k_group) {
      // Whole groups only, so that a run may follow.
      at += std::min(k_group, numbers.size() - at);
      continue;
    }
    append_literals(numbers.subspan(literals, at - literals), width, bytes);
    append_varint((end - at) << 1, bytes);
    for (int shift = 0; shift < width; shift += 8)
      bytes.push_back(static_cast<std::byte>(numbers[at] >> shift & 0xff));
    at = literals = end;
  }
  append_literals(numbers.subspan(literals), width, bytes);
}

template <class Unsigned>
void append_deltas(std::span<const Unsigned> numbers, Bytes& bytes) {
  using Signed = std::make_signed_t<Unsigned>;
  constexpr std::size_t k_block = 128, k_parts = 4, k_part = k_block / k_parts;
  append_varint(k_block, bytes);
  append_varint(k_parts, bytes);
  append_varint(numbers.size(), bytes);
  append_varint(numbers.empty() ? 0 : zigzag(static_cast<Signed>(numbers.front())), bytes);
  for (std::size_t first = 1; first < numbers.size(); first += k_block) {
    const std::size_t count = std::min(k_block, numbers.size() - first);
    // Differences wrap around, and so do the sums of readers.
    std::array<Unsigned, k_block> deltas{};
    Signed least = std::numeric_limits<Signed>::max();
    for (std::size_t i = 0; i < count; ++i) {
      deltas[i] = static_cast<Unsigned>(numbers[first + i] - numbers[first + i - 1]);
      least = std::min(least, static_cast<Signed>(deltas[i]));
    }
    append_varint(zigzag(least), bytes);
    std::array<int, k_parts> widths{};
    for (std::size_t i = 0; i < count; ++i) {
      deltas[i] -= static_cast<Unsigned>(least);
      int& width = widths[i / k_part];
      width = std::max(width, static_cast<int>(std::bit_width(deltas[i])));
    }
    for (const int width : widths) bytes.push_back(static_cast<std::byte>(width));
    for (std::size_t part = 0; part * k_part < count; ++part) {
      append_packed(std::span<const Unsigned>(deltas).subspan(part * k_part, k_part), widths[part], bytes);
    }
  }
}

template void append_deltas(std::span<const std::uint32_t> numbers, Bytes& bytes);
template void append_deltas(std::span<const std::uint64_t> numbers, Bytes& bytes);

}  // namespace alidade::database
