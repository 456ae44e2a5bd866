// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>

#include "base/scratch_file.h"
#include "cloud/point_cloud.h"
#include "cloud/scratch_cloud.h"
#include "octree/build.h"
#include "tools/console.h"

namespace alidade::tools {

/// The contents of an index file beside octree and attributes.
struct IndexRequest {
  Organisation organisation = Organisation::adaptive;
  double cell_size = 0.0;                   ///< of fixed organisation, see BuildOptions
  bool stored_order = false;                ///< points are numbered as the octree stores them
  std::optional<int> spacing_neighbours{};  ///< distances to this neighbour are measured and stored
  bool surfaces = false;                    ///< so are the surfaces that points lie on, and their spacings
  bool overwrite = false;
};

/// Builds the octree over a cloud, measures what is requested, writes the index file, and prints its size.
/// The cloud's positions are moved into the octree. Errors: as build() and save_index().
void write_index(const std::filesystem::path& path, PointCloud& cloud, const IndexRequest& request,
                 Verbosity verbosity);
/// Writes the index file of a cloud larger than memory. Requires a request without stored order.
void write_index(const std::filesystem::path& path, ScratchCloud& cloud, const IndexRequest& request,
                 const ScratchSpace& scratch, Verbosity verbosity);

}  // namespace alidade::tools
