// SPDX-License-Identifier: MIT
#include "cloud/laz/laszip_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "base/bytes.h"

namespace alidade {
namespace {

constexpr std::size_t k_items_place = 34;
constexpr std::size_t k_item_bytes = 6;
constexpr std::size_t k_most_items = 5;
constexpr std::uint32_t k_variable_chunks = 0xffffffff;

/// Versions of the rules that exist for an item: {oldest, newest}.
std::pair<int, int> versions_of(LazItemKind kind) {
  switch (kind) {
    case LazItemKind::wave_packet13:
      return {1, 1};
    case LazItemKind::byte:
    case LazItemKind::point10:
    case LazItemKind::gps_time11:
    case LazItemKind::rgb12:
      return {1, 2};
    default:
      return {2, 4};
  }
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
                              std::uint64_t place, int point_format, std::size_t point_size) {
  const HeaderFields fields(data, file_name, place);
  fields.require(data.size() >= k_items_place, 0, "the laszip record is too short",
                 fmt::format("{} bytes or more", k_items_place), data.size());
  LazLayout layout;
  const int compressor = fields.get<std::uint16_t>(0);
  fields.require(compressor <= 3, 0, "unknown compressor of points", "0 to 3", compressor);
  layout.compressor = static_cast<LazCompressor>(compressor);
  if (layout.compressor == LazCompressor::none) return layout;

  const int coder = fields.get<std::uint16_t>(2);
  fields.require(coder == 0, 2, "unknown entropy coder", "0", coder);
  const std::uint32_t chunk_size = fields.get<std::uint32_t>(12);
  layout.chunk_size = chunk_size == k_variable_chunks ? 0 : chunk_size;
  const std::size_t count = fields.get<std::uint16_t>(32);
  fields.require(count >= 1 && count <= k_most_items, 32, "bad number of items of a point",
                 fmt::format("1 to {}", k_most_items), count);
  fields.require(data.size() == k_items_place + count * k_item_bytes, 32, "bad size of the laszip record",
                 fmt::format("{} bytes for {} items", k_items_place + count * k_item_bytes, count),
                 data.size());

  const LazLayout standard = standard_laz_layout(point_format, point_size);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = k_items_place + i * k_item_bytes;
    layout.items.push_back({static_cast<LazItemKind>(fields.get<std::uint16_t>(at)),
                            fields.get<std::uint16_t>(at + 2), fields.get<std::uint16_t>(at + 4)});
  }
  const bool as_format = std::ranges::equal(
      layout.items, standard.items,
      [](const LazItem& a, const LazItem& b) { return a.kind == b.kind && a.size == b.size; });
  fields.require(as_format, k_items_place,
                 fmt::format("the items of the laszip record do not make a point of format {} and {} bytes",
                             point_format, point_size),
                 written(standard.items), written(layout.items));
  for (std::size_t i = 0; i < count; ++i) {
    const auto [oldest, newest] = versions_of(layout.items[i].kind);
    const int version = layout.items[i].version;
    fields.require(version >= oldest && version <= newest, k_items_place + i * k_item_bytes + 4,
                   fmt::format("unknown version of item {}", static_cast<int>(layout.items[i].kind)),
                   fmt::format("{} to {}", oldest, newest), version);
  }
  const bool layered = layout.compressor == LazCompressor::layered;
  fields.require(layered == (standard.compressor == LazCompressor::layered), 0,
                 fmt::format("the compressor cannot hold points of format {}", point_format),
                 layered ? "1 or 2" : "3", compressor);
  check_laz_extra_bytes(layout, file_name, fmt::format("byte {}", place + k_items_place));
  return layout;
}

}  // namespace alidade
