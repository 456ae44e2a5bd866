// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "cloud/written_column.h"

namespace alidade {

struct TextWriteOptions {
  /// Coordinates alone, with blanks between them and no header (XYZ), in place of all columns with commas
  /// between them and their names in front (CSV).
  bool coordinates_alone = false;
  bool overwrite = false;
  Progress progress{};  ///< in points
};

/// Writes a cloud as CSV or XYZ, a line per point in their order. Columns are those of written_columns(), colours
/// of 8 bits if that loses nothing, else of 16. Coordinates have the decimals of the lattice (decimals_of()),
/// other numbers as many digits as give the same value again; NaN, which stands for no value, is an empty cell.
/// Reference system and records are left out. Errors: as OutputFile.
void write_text(const std::filesystem::path& path, const PointCloud& cloud,
                const TextWriteOptions& options = {});

/// The same for a cloud of so many points that comes in pieces, twice if they have colours, with memory for one of them.
void write_text(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
                const TextWriteOptions& options = {});

}  // namespace alidade
