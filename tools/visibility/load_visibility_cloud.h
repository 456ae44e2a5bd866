// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "octree/indexed_cloud.h"
#include "tools/progress.h"
#include "tools/visibility/occluder_options.h"
#include "visibility/occluders.h"

namespace alidade {

/// A cloud, and what of it blocks sight.
struct VisibilityCloud {
  IndexedCloud cloud;
  AttributeColumns columns;            ///< of `cloud`, which therefore stays in its place
  std::optional<Occluders> occluders;  ///< always there

  const Octree& octree() const { return occluders->octree(); }
};

/// Loads cloud files or an index file, measures what they lack, shows progress, and says what blocks. What
/// classes and `attributes` say is in memory then. Errors: as load_indexed_cloud(), Occluders; no points.
std::unique_ptr<const VisibilityCloud> load_visibility_cloud(const std::vector<std::filesystem::path>& files,
                                                             const OccluderRequest& request,
                                                             AttributeSet attributes, Verbosity verbosity);

}  // namespace alidade
