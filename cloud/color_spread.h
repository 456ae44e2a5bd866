// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"

// Colours of LAS files are spread from the depth that they use to the full 16 bits (8-bit values times 257),
// and near infrared with them if it is not deeper. All files have one depth: the tiles of a survey are from
// one camera, and a dark tile of a 16-bit survey may have no value above 255. So all colours have to be read
// before the first is changed.

namespace alidade {

/// The rows [first, end) of a cloud that are from one LAS file with colours, and the largest values there.
struct ColoredRows {
  std::string file_name;
  std::uint64_t first = 0, end = UINT64_MAX;
  int largest_color = 0, largest_near_infrared = 0;
};

/// Updates the largest values of `files`, which are in the order of their rows, by the colours of a cloud, or
/// of a piece whose first point has the row `first_row`. Cost: a pass over the rows of the files.
void measure_colors(const PointCloud& piece, std::uint64_t first_row, std::vector<ColoredRows>& files);

/// Which colours have to be spread.
struct ColorSpread {
  bool colors = false, near_infrared = false;
  std::vector<ColoredRows> files;  ///< whose rows have to be spread, in their order

  /// Whether a row has to be spread. Cost: that of a search among the files.
  bool concerns(std::uint64_t row) const;

  static std::uint16_t spread(std::uint16_t value);
  static Color16 spread(const Color16& color) { return {spread(color.x), spread(color.y), spread(color.z)}; }
};

/// The spread of files that have been measured. Adds warnings about the depth, and about files that look as
/// if they had the other depth.
ColorSpread choose_spread(std::vector<ColoredRows> files, ColorDepth depth,
                          std::vector<std::string>& warnings);

/// Spreads the colours of a whole cloud, or of its columns from the row `first_row` on. Cost: a pass over the
/// rows of ColorSpread::files.
void apply(const ColorSpread& spread, std::span<Color16> colors, std::span<std::uint16_t> near_infrared,
           std::uint64_t first_row = 0);
inline void apply(const ColorSpread& spread, PointCloud& cloud) {
  apply(spread, cloud.colors, cloud.near_infrared);
}

}  // namespace alidade
