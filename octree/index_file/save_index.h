// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "octree/octree.h"

namespace alidade {

struct SaveIndexOptions {
  bool overwrite = false;  ///< replace an existing file
  Progress progress{};     ///< in bytes written
  /// Called with bytes of octree or columns that will not be read again.
  std::function<void(std::span<const std::byte>)> written{};
};

/// Writes an index file; it is written completely or not at all. `cloud` is the one the octree was built
/// over, with or without its positions: its attribute columns, coordinate reference system, records, files
/// and warnings are stored too. Memory: up to 32 MB beside octree and cloud. Colours are read twice, and
/// stored in 8 bits if all are multiples of 257 or of 256.
/// Errors: a column whose length is not that of the octree; a cloud on another lattice; those of OutputFile.
void save_index(const std::filesystem::path& path, const Octree& octree, const PointCloud& cloud,
                const SaveIndexOptions& options = {});

/// save_index() with attribute columns that lie elsewhere: those of the cloud and the values of its extra
/// dimensions do not count.
void save_index(const std::filesystem::path& path, const Octree& octree, const PointCloud& cloud,
                const AttributeColumns& columns, const SaveIndexOptions& options = {});

}  // namespace alidade
