// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"

// Brings the colours of all LAS files of a cloud from the depth they use to the full 16 bits (8-bit values
// times 257), and near infrared with them if it is no deeper. The depth is one for all: the tiles of a survey
// come from one camera, and a dark tile of a deep survey shows no value above 255 either. So all colours have
// to be seen before the first is changed.

namespace alidade {

/// The rows [first, end) that one LAS file with colours gave to a cloud, and the largest values there.
struct ColoredRows {
  std::string file_name;
  std::uint64_t first = 0, end = UINT64_MAX;
  int largest_color = 0, largest_near_infrared = 0;
};

/// Looks at the colours of a cloud, or of a piece whose first point has the row `first_row`. `files` are in
/// the order of their rows. Cost: a pass over the rows of the files.
void measure_colors(const PointCloud& piece, std::uint64_t first_row, std::vector<ColoredRows>& files);

/// What is to be done with the colours.
struct ColorSpread {
  bool colors = false, near_infrared = false;
  std::vector<ColoredRows> files;  ///< whose rows are concerned, in their order

  /// Whether a row is concerned. Cost: that of a search among the files.
  bool concerns(std::uint64_t row) const;

  static std::uint16_t spread(std::uint16_t value);
  static Color16 spread(const Color16& color) { return {spread(color.x), spread(color.y), spread(color.z)}; }
};

/// Decides for files that have been measured. What is done, and which files look as if they were of the other
/// depth, is added to the warnings.
ColorSpread choose_spread(std::vector<ColoredRows> files, ColorDepth depth,
                          std::vector<std::string>& warnings);

/// Does it with a whole cloud. Cost: a pass over the rows concerned.
void apply(const ColorSpread& spread, PointCloud& cloud);

}  // namespace alidade
