// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "cloud/written_column.h"

namespace alidade {

struct TextWriteOptions {
  /// Coordinates alone, with blanks between them and no header (XYZ), instead of all columns with commas
  /// between them and a header of names (CSV).
  bool coordinates_alone = false;
  bool overwrite = false;
  Progress progress{};  ///< in points
};

/// Writes a cloud as CSV or XYZ, a line per point, in their order. Columns are those of written_columns(),
/// colours of 8 bits if that loses nothing, else of 16. Coordinates have the decimals of the lattice
/// (decimals_of()), other numbers enough digits to restore the value; NaN, which means no value, is an empty
/// cell. Reference system and records are left out. Errors: as OutputFile.
void write_text(const std::filesystem::path& path, const PointCloud& cloud,
                const TextWriteOptions& options = {});

/// Writes a cloud of `point_count` points that arrives in pieces, with memory for one of them. If they have
/// colours, CSV requests all pieces twice.
void write_text(const std::filesystem::path& path, std::size_t point_count, const PointPieces& pieces,
                const TextWriteOptions& options = {});

}  // namespace alidade
