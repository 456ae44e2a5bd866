// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "octree/cloud/las_point.h"
#include "octree/cloud/laz/laz_layout.h"

namespace alidade::test {

/// Input of the fuzz targets of LAZ codecs: four bytes that say format, extra bytes, versions of the items
/// and number of points, then a chunk.
struct LazCase {
  std::array<unsigned, 4> head;
  std::size_t point_count;  ///< at least 1
  std::span<const std::byte> chunk;

  /// `first_format`: 0 for the pointwise codec, 6 for the layered one.
  LazLayout layout(int first_format) const {
    const int formats = first_format == 0 ? 6 : 5;
    const int format = first_format + static_cast<int>(head[0]) % formats;
    const auto base = static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size);
    LazLayout layout = standard_laz_layout(format, base + head[1] % 3);
    const auto lowest_version = static_cast<std::uint16_t>(first_format == 0 ? 1 : 3);
    for (LazItem& item : layout.items)
      if (item.kind != LazItemKind::wave_packet13)
        item.version = static_cast<std::uint16_t>(lowest_version + head[2] % 2);
    return layout;
  }
};

inline constexpr std::size_t k_laz_case_head = 4;

/// Requires k_laz_case_head bytes or more.
inline LazCase laz_case(std::span<const std::byte> input) {
  LazCase laz{.head = {}, .point_count = 0, .chunk = input.subspan(k_laz_case_head)};
  for (std::size_t i = 0; i < k_laz_case_head; ++i) laz.head[i] = std::to_integer<unsigned>(input[i]);
  laz.point_count = std::max(laz.head[3], 1u);
  return laz;
}

}  // namespace alidade::test
