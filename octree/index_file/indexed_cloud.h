// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/index_file/index_file.h"
#include "octree/octree.h"

namespace alidade {

/// A cloud that can be asked: octree, and attributes by point id. The octree of one index file comes straight
/// from the map; everything else is read and built.
struct IndexedCloud {
  Octree octree;
  /// What the files said; it has the attribute columns if they were read, and no positions.
  PointCloud cloud;
  std::optional<IndexFile> index;  ///< the columns lie in here if it is there

  /// The attribute columns, wherever they lie; valid as long as this object stands unchanged instead.
  AttributeColumns columns() const { return index ? index->columns() : columns_of(cloud); }
};

struct IndexCloudOptions {
  ReadOptions read{};    ///< attributes and colour depth; an index file gives all that it has, as it stands
  BuildOptions build{};  ///< of files that have no octree yet
};

/// Loads clouds for queries: a single index file
/// is mapped and checked (IndexFile::tree), anything else goes through read_cloud() and build().
/// read.progress is in bytes; while the octree is built it repeats the last numbers. `cloud.files` are the
/// files that the points come from, also those an index was made of. Errors: as read_cloud(), build() and
/// open_index(). Memory: for an index file about 1 B per point.
IndexedCloud load_indexed_cloud(const CloudInputs& inputs, const IndexCloudOptions& options = {});

}  // namespace alidade
