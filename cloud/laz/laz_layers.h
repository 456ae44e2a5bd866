// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// Which attributes of a layered LAZ chunk are wanted; those the point format lacks mean nothing. x, y,
/// returns and scanner channel are always decoded, as all others need them. What is left out costs nothing.
struct LazLayers {
  bool z = true;
  bool classification = true;
  bool flags = true;  ///< of the classification, scan direction and edge of flight line
  bool intensity = true;
  bool scan_angle = true;
  bool user_data = true;
  bool point_source = true;
  bool gps_time = true;
  bool color = true;
  bool near_infrared = true;
  bool wave_packet = true;
  bool extra_bytes = true;

  /// Positions and returns, nothing else.
  static constexpr LazLayers positions() {
    return {.z = true,
            .classification = false,
            .flags = false,
            .intensity = false,
            .scan_angle = false,
            .user_data = false,
            .point_source = false,
            .gps_time = false,
            .color = false,
            .near_infrared = false,
            .wave_packet = false,
            .extra_bytes = false};
  }
};

}  // namespace alidade
