// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace alidade {

/// How the layered LAZ codec groups points by return number r and number of returns n of their pulse.
struct ReturnsClass {
  std::uint8_t map;         ///< 0 to 5: neighbouring points of one group are spaced alike
  std::uint8_t level;       ///< |n - r|, at most 7
  std::uint8_t return_end;  ///< 2 * (r == 1) + (r >= n)
  std::uint8_t single;      ///< n == 1
};

/// By the byte of the record: r in bits 0-3, n in bits 4-7.
inline constexpr std::array<ReturnsClass, 256> k_returns_classes = [] {
  // By n, then r.
  constexpr std::uint8_t k_map[16][16] = {
      {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5}, {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
      {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3}, {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
      {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5},
  };
  std::array<ReturnsClass, 256> classes{};
  for (unsigned n = 0; n < 16; ++n)
    for (unsigned r = 0; r < 16; ++r)
      classes[16 * n + r] = {.map = k_map[n][r],
                             .level = static_cast<std::uint8_t>(std::min(n < r ? r - n : n - r, 7u)),
                             .return_end = static_cast<std::uint8_t>(2 * (r == 1) + (r >= n)),
                             .single = static_cast<std::uint8_t>(n == 1)};
  return classes;
}();

}  // namespace alidade
