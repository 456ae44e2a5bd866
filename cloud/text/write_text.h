// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "base/progress.h"
#include "cloud/point_cloud.h"

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
/// other numbers as many digits as give the same value again. Reference system and records are left out.
/// Errors: as OutputFile.
void write_text(const std::filesystem::path& path, const PointCloud& cloud,
                const TextWriteOptions& options = {});

}  // namespace alidade
