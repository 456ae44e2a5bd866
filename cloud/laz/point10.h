// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// The first 20 bytes of point data records of formats 0 to 5, as they stand in LAS files.
struct Point10 {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  std::uint8_t bits = 0;  ///< from the lowest: return number 3, number of returns 3, scan direction, edge
  std::uint8_t classification = 0;
  std::uint8_t scan_angle = 0;
  std::uint8_t user_data = 0;
  std::uint16_t source = 0;

  unsigned return_number() const { return bits & 7; }
  unsigned return_count() const { return bits >> 3 & 7; }
  unsigned scan_direction() const { return bits >> 6 & 1; }
};
static_assert(sizeof(Point10) == 20);

}  // namespace alidade
