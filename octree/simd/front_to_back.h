// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "octree/node.h"

namespace alidade::simd {

struct SlotOrder {
  std::array<std::uint8_t, k_node_width> slot;
  int count = 0;
};

/// Every third bit.
constexpr std::array<std::uint32_t, 256> k_spread_byte = [] {
  std::array<std::uint32_t, 256> spread{};
  for (std::uint32_t value = 0; value < 256; ++value) {
    for (int bit = 0; bit < 8; ++bit) spread[value] |= (value >> bit & 1u) << (3 * bit);
  }
  return spread;
}();

/// The slots of a set (bits) in the order in which any ray of this octant (bit per axis: direction negative)
/// meets them. Cells of one tree are disjoint, so their order is that of the Morton keys of any point inside,
/// mirrored on the axes along which the ray goes down.
inline SlotOrder front_to_back(const Node& node, unsigned octant, unsigned slots) {
  const std::uint8_t mirror[3] = {static_cast<std::uint8_t>((octant & 1u) != 0 ? 0xff : 0),
                                  static_cast<std::uint8_t>((octant & 2u) != 0 ? 0xff : 0),
                                  static_cast<std::uint8_t>((octant & 4u) != 0 ? 0xff : 0)};
  std::array<std::uint32_t, k_node_width> keys;
  SlotOrder order;
  for (; slots != 0; slots &= slots - 1) {
    const int slot = std::countr_zero(slots);
    const std::uint32_t key =
        (k_spread_byte[node.low[0][slot] ^ mirror[0]] | k_spread_byte[node.low[1][slot] ^ mirror[1]] << 1 |
         k_spread_byte[node.low[2][slot] ^ mirror[2]] << 2)
            << 3 |
        static_cast<std::uint32_t>(slot);
    int at = order.count++;
    for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
    keys[at] = key;
  }
  for (int place = 0; place < order.count; ++place)
    order.slot[place] = static_cast<std::uint8_t>(keys[place] & 7u);
  return order;
}

}  // namespace alidade::simd
