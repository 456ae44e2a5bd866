// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

// Morton order (z-order): the bits of three cell coordinates interleaved, so that every octree cell is one
// contiguous range of keys. Bit 3i of a key is bit i of x, 3i + 1 of y, 3i + 2 of z.

namespace alidade {

/// Bits per axis that a key of 64 bits holds.
constexpr int k_morton_bits = 21;

/// A key of 96 bits, for three whole 32-bit coordinates.
using WideMortonKey = unsigned __int128;

/// Spreads the low 21 bits of a value to every third bit.
constexpr std::uint64_t morton_spread(std::uint64_t value) {
  value &= 0x1fffff;
  value = (value | value << 32) & 0x001f00000000ffff;
  value = (value | value << 16) & 0x001f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  value = (value | value << 2) & 0x1249249249249249;
  return value;
}

/// Inverse of morton_spread.
constexpr std::uint32_t morton_gather(std::uint64_t key) {
  key &= 0x1249249249249249;
  key = (key | key >> 2) & 0x10c30c30c30c30c3;
  key = (key | key >> 4) & 0x100f00f00f00f00f;
  key = (key | key >> 8) & 0x001f0000ff0000ff;
  key = (key | key >> 16) & 0x001f00000000ffff;
  key = (key | key >> 32) & 0x1fffff;
  return static_cast<std::uint32_t>(key);
}

/// Key of a cell; of each coordinate the low 21 bits.
constexpr std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return morton_spread(x) | morton_spread(y) << 1 | morton_spread(z) << 2;
}

/// Coordinate of a cell along an axis (0, 1, 2).
constexpr std::uint32_t morton_coordinate(std::uint64_t key, int axis) {
  return morton_gather(key >> axis);
}

/// Key of a cell; any coordinates.
constexpr WideMortonKey wide_morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return WideMortonKey{morton_key(x >> k_morton_bits, y >> k_morton_bits, z >> k_morton_bits)}
             << 3 * k_morton_bits |
         morton_key(x, y, z);
}

constexpr std::uint32_t morton_coordinate(WideMortonKey key, int axis) {
  const auto low = static_cast<std::uint64_t>(key) & 0x7fffffffffffffff;
  const auto high = static_cast<std::uint64_t>(key >> 3 * k_morton_bits);
  return morton_coordinate(high, axis) << k_morton_bits | morton_coordinate(low, axis);
}

/// Number of the highest bit that is set; -1 if none is.
constexpr int highest_bit(std::uint64_t key) {
  return std::bit_width(key) - 1;
}
constexpr int highest_bit(WideMortonKey key) {
  const auto high = static_cast<std::uint64_t>(key >> 64);
  return high != 0 ? 64 + highest_bit(high) : highest_bit(static_cast<std::uint64_t>(key));
}

}  // namespace alidade
