// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_reader.h"
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

/// Does it with a whole cloud, or with its columns from the row `first_row` on. Cost: a pass over the rows concerned.
void apply(const ColorSpread& spread, std::span<Color16> colors, std::span<std::uint16_t> near_infrared,
           std::uint64_t first_row = 0);
inline void apply(const ColorSpread& spread, PointCloud& cloud) {
  apply(spread, cloud.colors, cloud.near_infrared);
}

/// What is known of a cloud once it has been read piece by piece.
struct PiecewiseCloud {
  /// The points that were not handed over, which come behind all that were; lattice, reference system,
  /// records, files and warnings of the whole.
  PointCloud rest;
  std::uint64_t point_count = 0;  ///< of the whole
  AttributeSet attributes{};      ///< that a file with points has
  /// What remains to be done with the colours, also of the rest.
  ColorSpread spread{};
};

/// read_cloud() for a cloud that memory need not hold: same points in the same rows, same warnings, but
/// points are handed over as `pieces` says, and colours are as the files have them. The pieces' `take` is
/// given clouds on the lattice of the whole; what else they say of it may still grow. Files are read one
/// after another. Errors: as read_cloud(). Memory: that of CloudReader::read_in_pieces().
PiecewiseCloud read_in_pieces(const CloudInputs& inputs, const ReadOptions& options,
                              const CloudPieces& pieces);

}  // namespace alidade
