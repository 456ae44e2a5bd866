// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_layout.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "cloud/las/las_header.h"

namespace alidade {

std::size_t LazLayout::record_size() const {
  std::size_t size = 0;
  for (const LazItem& item : items) size += item.size;
  return size;
}

void check_laz_extra_bytes(const LazLayout& layout, const std::string& file_name, std::string location) {
  for (const LazItem& item : layout.items) {
    const bool is_extra = item.kind == LazItemKind::byte || item.kind == LazItemKind::byte14;
    if (!is_extra || item.size <= k_most_laz_extra_bytes) continue;
    throw Error({.file = file_name,
                 .location = std::move(location),
                 .problem = "too many extra bytes per point for LAZ",
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

namespace {

constexpr std::size_t k_items_offset = 34;
constexpr std::size_t k_item_bytes = 6;
constexpr std::size_t k_most_items = 5;
constexpr std::uint32_t k_variable_chunks = 0xffffffff;

/// Versions of the rules that exist for an item: {oldest, newest}.
std::pair<int, int> versions_of(LazItemKind kind) {
  if (kind == LazItemKind::wave_packet13) return {1, 1};
  return kind < LazItemKind::wave_packet13 ? std::pair(1, 2) : std::pair(2, 4);
}

std::string written(const std::vector<LazItem>& items) {
  std::string text;
  for (const LazItem& item : items) {
    text += fmt::format("{}{} of {} bytes", text.empty() ? "" : ", ", static_cast<int>(item.kind), item.size);
  }
  return text;
}

}  // namespace

LazLayout parse_laszip_record(std::span<const std::byte> data, const std::string& file_name,
                              std::uint64_t offset, int point_format, std::size_t point_size) {
  const HeaderFields fields(data, file_name, offset);
  fields.require(data.size() >= k_items_offset, 0, "truncated laszip record",
                 fmt::format("at least {} bytes", k_items_offset), data.size());
  LazLayout layout;
  const int compressor = fields.get<std::uint16_t>(0);
  fields.require(compressor <= 3, 0, "unsupported compressor", "0 to 3", compressor);
  layout.compressor = static_cast<LazCompressor>(compressor);
  if (layout.compressor == LazCompressor::none) return layout;

  const int coder = fields.get<std::uint16_t>(2);
  fields.require(coder == 0, 2, "unsupported entropy coder", "0", coder);
  const std::uint32_t chunk_size = fields.get<std::uint32_t>(12);
  layout.chunk_size = chunk_size == k_variable_chunks ? 0 : chunk_size;
  const std::size_t count = fields.get<std::uint16_t>(32);
  fields.require(count >= 1 && count <= k_most_items, 32, "invalid number of items",
                 fmt::format("1 to {}", k_most_items), count);
  fields.require(data.size() == k_items_offset + count * k_item_bytes, 32, "wrong size of the laszip record",
                 fmt::format("{} bytes for {} items", k_items_offset + count * k_item_bytes, count),
                 data.size());

  const LazLayout standard = standard_laz_layout(point_format, point_size);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = k_items_offset + i * k_item_bytes;
    layout.items.push_back({static_cast<LazItemKind>(fields.get<std::uint16_t>(at)),
                            fields.get<std::uint16_t>(at + 2), fields.get<std::uint16_t>(at + 4)});
  }
  const bool as_format = std::ranges::equal(
      layout.items, standard.items,
      [](const LazItem& a, const LazItem& b) { return a.kind == b.kind && a.size == b.size; });
  fields.require(as_format, k_items_offset,
                 fmt::format("the items of the laszip record do not match point format {} with {} bytes",
                             point_format, point_size),
                 written(standard.items), written(layout.items));
  for (std::size_t i = 0; i < count; ++i) {
    const auto [oldest, newest] = versions_of(layout.items[i].kind);
    const int version = layout.items[i].version;
    fields.require(version >= oldest && version <= newest, k_items_offset + i * k_item_bytes + 4,
                   fmt::format("unsupported version of item {}", static_cast<int>(layout.items[i].kind)),
                   fmt::format("{} to {}", oldest, newest), version);
  }
  const bool layered = layout.compressor == LazCompressor::layered;
  fields.require(layered == (standard.compressor == LazCompressor::layered), 0,
                 fmt::format("the compressor does not support point format {}", point_format),
                 layered ? "1 or 2" : "3", compressor);
  check_laz_extra_bytes(layout, file_name, fmt::format("byte {}", offset + k_items_offset));
  return layout;
}

VariableLengthRecord laszip_record(const LazLayout& layout) {
  VariableLengthRecord record{
      .user_id = k_laszip_user_id,
      .record_id = k_laszip_record_id,
      .description = "how the points are packed",
      .data = std::vector<std::uint8_t>(k_items_offset + k_item_bytes * layout.items.size()),
      .extended = false};
  const std::span<std::byte> data = std::as_writable_bytes(std::span(record.data));
  std::byte* const at = data.data();
  store(at, layout.compressor);
  // The version of the rules that readers expect is 2.2. The coder at byte 2 and the options at byte 8 are 0.
  store<std::uint8_t>(at + 4, 2);
  store<std::uint8_t>(at + 5, 2);
  store(at + 12, layout.chunk_size == 0 ? UINT32_MAX : layout.chunk_size);
  store<std::int64_t>(at + 16, -1);  // no special extended records
  store<std::int64_t>(at + 24, -1);
  store(at + 32, static_cast<std::uint16_t>(layout.items.size()));
  for (std::size_t i = 0; i < layout.items.size(); ++i) {
    std::byte* const item = at + k_items_offset + k_item_bytes * i;
    store(item, layout.items[i].kind);
    store(item + 2, layout.items[i].size);
    store(item + 4, layout.items[i].version);
  }
  return record;
}

}  // namespace alidade
