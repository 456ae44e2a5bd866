// SPDX-License-Identifier: MIT
#include "cloud/color_spread.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <utility>

#include "cloud/joined_files.h"

namespace alidade {
namespace {

constexpr int k_largest_8_bit = 255;

/// The remark on a file whose largest colour is not 0; null without such a file.
const char* remark_on(bool is_deep, bool spreads, ColorDepth depth) {
  if (depth == ColorDepth::bits_8)
    return is_deep ? "{}: colours above 255 (maximum {}) are clamped, because --color-depth is 8" : nullptr;
  if (is_deep) return nullptr;
  return spreads ? "{}: assuming 8-bit colours (maximum {}); --color-depth 16 reads them as 16 bits"
                 : "{}: reading colours as 16 bits like those of other files, although none exceeds 255 "
                   "(maximum {})";
}

}  // namespace

void measure_colors(const PointCloud& piece, std::uint64_t first_row, std::vector<ColoredRows>& files) {
  const std::uint64_t end_row = first_row + piece.size();
  for (std::size_t i = files.size(); i > 0 && files[i - 1].end > first_row; --i) {
    ColoredRows& file = files[i - 1];
    const auto begin = static_cast<std::size_t>(std::max(file.first, first_row) - first_row);
    const auto end = static_cast<std::size_t>(std::max(std::min(file.end, end_row), first_row) - first_row);
    for (std::size_t row = begin; row < end && row < piece.colors.size(); ++row) {
      const Color16& color = piece.colors[row];
      file.largest_color =
          std::max(file.largest_color, static_cast<int>(std::max({color.x, color.y, color.z})));
    }
    for (std::size_t row = begin; row < end && row < piece.near_infrared.size(); ++row)
      file.largest_near_infrared =
          std::max(file.largest_near_infrared, static_cast<int>(piece.near_infrared[row]));
  }
}

bool ColorSpread::concerns(std::uint64_t row) const {
  const auto behind = std::ranges::upper_bound(files, row, {}, &ColoredRows::first);
  return behind != files.begin() && row < std::prev(behind)->end;
}

std::uint16_t ColorSpread::spread(std::uint16_t value) {
  return static_cast<std::uint16_t>(std::min<int>(value, k_largest_8_bit) * 257);
}

ColorSpread choose_spread(std::vector<ColoredRows> files, ColorDepth depth,
                          std::vector<std::string>& warnings) {
  if (depth == ColorDepth::bits_16) return {};
  int largest = 0;
  bool is_near_infrared_deep = false;
  for (const ColoredRows& file : files) {
    largest = std::max(largest, file.largest_color);
    is_near_infrared_deep |= file.largest_near_infrared > k_largest_8_bit;
  }
  const bool spreads = depth == ColorDepth::bits_8 || largest <= k_largest_8_bit;
  // All files with a remark have the same.
  const char* remark = nullptr;
  SomeFiles remarkable;
  int largest_of_them = 0;
  for (const ColoredRows& file : files) {
    const char* const own = remark_on(file.largest_color > k_largest_8_bit, spreads, depth);
    if (own == nullptr || file.largest_color == 0) continue;
    remark = own;
    largest_of_them = std::max(largest_of_them, file.largest_color);
    remarkable.add(file.file_name);
  }
  if (remark != nullptr)
    warnings.push_back(fmt::format(fmt::runtime(remark), remarkable.text(), largest_of_them));
  if (!spreads || largest == 0) return {};
  return {.colors = true, .near_infrared = !is_near_infrared_deep, .files = std::move(files)};
}

void apply(const ColorSpread& spread, std::span<Color16> colors, std::span<std::uint16_t> near_infrared,
           std::uint64_t first_row) {
  if (!spread.colors) return;
  const auto spread_rows = [&](auto column, const ColoredRows& file) {
    const std::uint64_t first = std::max(file.first, first_row), end = std::max(file.end, first);
    for (std::uint64_t row = first - first_row; row < end - first_row && row < column.size(); ++row)
      column[row] = ColorSpread::spread(column[row]);
  };
  for (const ColoredRows& file : spread.files) {
    spread_rows(colors, file);
    if (spread.near_infrared) spread_rows(near_infrared, file);
  }
}

}  // namespace alidade
