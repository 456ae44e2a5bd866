// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

// Morton order (z-order): the bits of three cell coordinates interleaved, so that every octree cell is one
// contiguous range of keys. Bit 3i of a key is bit i of x, 3i + 1 of y, 3i + 2 of z.

namespace alidade {

/// Bits per axis that a key holds.
constexpr int k_morton_bits = 21;

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

/// Key of a cell; coordinates below 2^21.
constexpr std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return morton_spread(x) | morton_spread(y) << 1 | morton_spread(z) << 2;
}

/// Coordinate of a cell along an axis (0, 1, 2).
constexpr std::uint32_t morton_coordinate(std::uint64_t key, int axis) {
  return morton_gather(key >> axis);
}

}  // namespace alidade
