// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/laz/laz_layers.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// Layers of a compressed file that hold the attributes that are kept.
inline LazLayers layers_of(AttributeSet kept) {
  return {.z = true,
          .classification = kept.contains(Attribute::classification),
          .flags = kept.contains(Attribute::flags),
          .intensity = kept.contains(Attribute::intensity),
          .scan_angle = kept.contains(Attribute::scan_angle),
          .user_data = kept.contains(Attribute::user_data),
          .point_source = kept.contains(Attribute::point_source_id),
          .gps_time = kept.contains(Attribute::gps_time),
          .color = kept.contains(Attribute::color),
          .near_infrared = kept.contains(Attribute::near_infrared),
          .wave_packet = false,
          .extra_bytes = kept.contains(Attribute::extra_dimensions) || kept.contains(Attribute::normal)};
}

}  // namespace alidade
