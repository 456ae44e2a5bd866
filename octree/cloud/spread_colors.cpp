// SPDX-License-Identifier: MIT
#include "octree/cloud/spread_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace alidade {
namespace {

constexpr int k_largest_8_bit = 255;

std::uint16_t spread(std::uint16_t value) {
  return static_cast<std::uint16_t>(std::min<int>(value, k_largest_8_bit) * 257);
}

template <class Value>
std::span<Value> rows_of(std::vector<Value>& column, const ColoredRows& file) {
  return std::span(column).subspan(file.first, file.end - file.first);
}

int largest_channel(std::span<const Color16> colors) {
  int largest = 0;
  for (const Color16& color : colors) {
    largest =
        std::max({largest, static_cast<int>(color.x), static_cast<int>(color.y), static_cast<int>(color.z)});
  }
  return largest;
}

/// What to say of a file whose largest colour is not 0; null if nothing.
const char* remark_on(bool is_deep, bool spreads, ColorDepth depth) {
  if (depth == ColorDepth::bits_8)
    return is_deep ? "{}: colours above 255 (largest value {}) are cut, because --color-depth is 8" : nullptr;
  if (is_deep) return nullptr;
  return spreads ? "{}: colours use 8 of 16 bits (largest value {}); pass --color-depth 16 if that is wrong"
                 : "{}: colours are taken as 16 bits like those of other files, though none exceeds 255 "
                   "(largest value {})";
}

}  // namespace

void spread_colors(PointCloud& cloud, std::span<const ColoredRows> files, ColorDepth depth) {
  if (depth == ColorDepth::bits_16) return;
  std::vector<int> largest_of;
  for (const ColoredRows& file : files) largest_of.push_back(largest_channel(rows_of(cloud.colors, file)));
  const int largest = largest_of.empty() ? 0 : *std::max_element(largest_of.begin(), largest_of.end());
  const bool spreads = depth == ColorDepth::bits_8 || largest <= k_largest_8_bit;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const char* const remark = remark_on(largest_of[i] > k_largest_8_bit, spreads, depth);
    if (remark && largest_of[i] > 0)
      cloud.warnings.push_back(fmt::format(fmt::runtime(remark), files[i].file_name, largest_of[i]));
  }
  if (!spreads || largest == 0) return;

  const auto is_shallow = [&](const ColoredRows& file) {
    return std::ranges::all_of(rows_of(cloud.near_infrared, file),
                               [](std::uint16_t value) { return value <= k_largest_8_bit; });
  };
  const bool spreads_near_infrared = !cloud.near_infrared.empty() && std::ranges::all_of(files, is_shallow);
  for (const ColoredRows& file : files) {
    for (Color16& color : rows_of(cloud.colors, file))
      color = {spread(color.x), spread(color.y), spread(color.z)};
    if (!spreads_near_infrared) continue;
    for (std::uint16_t& value : rows_of(cloud.near_infrared, file)) value = spread(value);
  }
}

}  // namespace alidade
