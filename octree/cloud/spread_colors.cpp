// SPDX-License-Identifier: MIT
#include "octree/cloud/spread_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace alidade {
namespace {

constexpr int k_largest_8_bit = 255;

std::uint16_t spread(std::uint16_t value) {
  return static_cast<std::uint16_t>(std::min<int>(value, k_largest_8_bit) * 257);
}

}  // namespace

void spread_colors(PointCloud& cloud, std::size_t first_row, ColorDepth depth, const std::string& file_name) {
  if (depth == ColorDepth::bits_16) return;
  int largest = 0;
  for (std::size_t row = first_row; row < cloud.colors.size(); ++row) {
    const Color16& color = cloud.colors[row];
    largest =
        std::max({largest, static_cast<int>(color.x), static_cast<int>(color.y), static_cast<int>(color.z)});
  }
  if (largest == 0 || (depth == ColorDepth::automatic && largest > k_largest_8_bit)) return;
  if (depth == ColorDepth::automatic) {
    cloud.warnings.push_back(
        fmt::format("{}: colours use 8 of 16 bits (largest value {}); pass --color-depth 16 if that is wrong",
                    file_name, largest));
  } else if (largest > k_largest_8_bit) {
    cloud.warnings.push_back(fmt::format(
        "{}: colours above 255 (largest value {}) are cut, because --color-depth is 8", file_name, largest));
  }
  for (std::size_t row = first_row; row < cloud.colors.size(); ++row) {
    Color16& color = cloud.colors[row];
    color = {spread(color.x), spread(color.y), spread(color.z)};
  }
  const auto infrared = cloud.near_infrared.begin() +
                        static_cast<std::ptrdiff_t>(std::min(first_row, cloud.near_infrared.size()));
  if (std::all_of(infrared, cloud.near_infrared.end(),
                  [](std::uint16_t value) { return value <= k_largest_8_bit; })) {
    std::transform(infrared, cloud.near_infrared.end(), infrared, spread);
  }
}

}  // namespace alidade
