// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "database/point_filter.h"
#include "jobs/load_cloud.h"
#include "octree/index_file/index_file.h"
#include "tools/options.h"

namespace alidade::tools {

using jobs::add_scratch_memory;
using jobs::check_map_unit;
using jobs::cloud_formats;
using jobs::scratch_beside;

/// jobs::load_cloud() for a command, with its messages.
IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options);

/// Whether a part of a cloud can be read from its database: 'alidade sql load' has stored it, and no option
/// changes its points. Errors: those of opening a table on a server.
bool has_parts(const CloudInput& input);

/// The unit of parts of a cloud in a database: "chunks" of SQLite, "points" of a server.
const char* part_unit(const CloudInput& input);

/// Reads those points of a cloud in a database that are needed: at least all for which a filter holds
/// (database/sqlite/stored_cloud.h, database/server/server_clouds.h). Requires has_parts(input).
database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress);

/// "chunks read" or "points read", as a line of a table.
std::string part_table(const database::CloudPart& part);

}  // namespace alidade::tools
