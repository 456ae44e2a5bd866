// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// What the first layer of a layered LAZ chunk, that of returns and positions, tells all others about a
/// point.
struct LayeredPoint {
  enum Change : std::uint8_t {
    k_number_of_returns = 4,
    k_scan_angle = 8,
    k_gps_time = 16,
    k_point_source = 32,
    k_channel = 64  ///< the scanner channel is not that of the point before
  };

  std::uint8_t channel;     ///< scanner channel, 0 to 3
  std::uint8_t changes;     ///< Change bits, against the last point of the channel; bits 0-1: return number
  std::uint8_t z_context;   ///< how many bits x and y differed by
  std::uint8_t level;       ///< distance of the return from the last one, at most 7
  std::uint8_t return_end;  ///< 2 if it is the first return, plus 1 if it is the last

  bool has(Change change) const { return (changes & change) != 0; }
};

}  // namespace alidade
