// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "database/cloud_part.h"
#include "database/point_filter.h"
#include "octree/progress.h"

namespace alidade {

/// Reads those points of a cloud in a database that are needed: at least all for which a filter holds
/// (database/sqlite/read_cloud_part.h). Requires lies_in_database(name).
CloudPart read_database_part(const std::filesystem::path& name, std::span<const PointFilter> any_of,
                             AttributeSet attributes, const Progress& progress);

/// "chunks read", as a line of a table.
std::string part_table(const CloudPart& part);

}  // namespace alidade
