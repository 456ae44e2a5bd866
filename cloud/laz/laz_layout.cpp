// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_layout.h"

#include <cassert>
#include <cstdint>
#include <utility>

#include "base/error.h"
#include "cloud/las/las_point.h"

namespace alidade {

std::size_t LazLayout::record_size() const {
  std::size_t size = 0;
  for (const LazItem& item : items) size += item.size;
  return size;
}

void check_laz_extra_bytes(const LazLayout& layout, const std::string& file_name, std::string place) {
  for (const LazItem& item : layout.items) {
    const bool is_extra = item.kind == LazItemKind::byte || item.kind == LazItemKind::byte14;
    if (!is_extra || item.size <= k_most_laz_extra_bytes) continue;
    throw Error({.file = file_name,
                 .place = std::move(place),
                 .problem = "too many extra bytes of a point for LAZ",
                 .expected = "at most " + std::to_string(k_most_laz_extra_bytes),
                 .found = std::to_string(item.size)});
  }
}

LazLayout standard_laz_layout(int point_format, std::size_t record_size, std::uint32_t chunk_size) {
  assert(point_format >= 0 && point_format < k_las_point_formats);
  const LasPointLayout& layout = k_las_point_layouts[static_cast<std::size_t>(point_format)];
  const std::size_t base_size = static_cast<std::size_t>(layout.size);
  assert(record_size >= base_size && record_size <= UINT16_MAX);
  const std::uint16_t extra_bytes = static_cast<std::uint16_t>(record_size - base_size);
  const bool has_wave_packet = point_format == 4 || point_format == 5 || point_format >= 9;
  LazLayout laz;
  laz.chunk_size = chunk_size;
  if (layout.legacy) {
    laz.compressor = LazCompressor::pointwise_chunked;
    laz.items.push_back({LazItemKind::point10, 20, 2});
    if (layout.gps_time >= 0) laz.items.push_back({LazItemKind::gps_time11, 8, 2});
    if (layout.color >= 0) laz.items.push_back({LazItemKind::rgb12, 6, 2});
    if (has_wave_packet) laz.items.push_back({LazItemKind::wave_packet13, 29, 1});
    if (extra_bytes > 0) laz.items.push_back({LazItemKind::byte, extra_bytes, 2});
    return laz;
  }
  laz.compressor = LazCompressor::layered;
  laz.items.push_back({LazItemKind::point14, 30, 3});
  if (layout.near_infrared >= 0) {
    laz.items.push_back({LazItemKind::rgb_nir14, 8, 3});
  } else if (layout.color >= 0) {
    laz.items.push_back({LazItemKind::rgb14, 6, 3});
  }
  if (has_wave_packet) laz.items.push_back({LazItemKind::wave_packet14, 29, 3});
  if (extra_bytes > 0) laz.items.push_back({LazItemKind::byte14, extra_bytes, 3});
  return laz;
}

}  // namespace alidade
