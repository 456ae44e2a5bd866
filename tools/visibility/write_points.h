// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "octree/indexed_cloud.h"
#include "tools/progress.h"

namespace alidade {

/// A column that a command adds to the points of a cloud.
struct ResultColumn {
  ExtraDimension description;  ///< its `values` are empty
  /// Writes the values of the points [first, first + count), little endian and one after another.
  std::function<void(std::size_t first, std::size_t count, std::uint8_t* values)> fill;
};

/// Error unless the name ends in .las or .ply.
void check_points_name(const std::filesystem::path& file);

/// The points of a cloud in their order, with all their attributes, scale, offset, reference system and LAS
/// records, and with these columns: LAS 1.4 or PLY by the ending. Columns of the cloud's own that have one of
/// their names are left out, which is said. Memory: of LAS some mebibytes, of PLY another copy of the cloud.
/// Errors: as LasWriter, write_ply().
void write_points(const std::filesystem::path& file, const IndexedCloud& cloud,
                  const std::vector<ResultColumn>& results, bool overwrite, Verbosity verbosity);

}  // namespace alidade
