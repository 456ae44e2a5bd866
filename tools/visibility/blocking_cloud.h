// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octree/index_file/indexed_cloud.h"
#include "tools/console.h"
#include "tools/visibility/occluder_options.h"
#include "visibility/sight_line.h"

namespace alidade {

/// A cloud, and what of it blocks sight.
struct VisibilityCloud {
  IndexedCloud cloud;
  AttributeColumns columns;            ///< of `cloud`, which therefore stays in its place
  std::optional<Occluders> occluders;  ///< empty until they are measured
  std::string what_blocks;             ///< the same in words

  const Octree& octree() const { return occluders ? occluders->octree() : cloud.octree; }
};

/// Loads cloud files or an index file and shows progress; occluders are still to be measured. What classes
/// and `attributes` say is in memory then. Errors: as load_indexed_cloud(); no points; coordinates
/// in degrees (check_map_unit.h).
std::unique_ptr<VisibilityCloud> load_cloud_alone(const std::vector<std::filesystem::path>& files,
                                                  bool partial, AttributeSet attributes, Verbosity verbosity);

/// Measures what the cloud lacks, shows progress, and says what blocks. May take long, so what else can be
/// wrong is better found before. Errors: as Occluders.
void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Verbosity verbosity);

}  // namespace alidade
