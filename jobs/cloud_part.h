// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"

namespace alidade::jobs {

/// Whether a part of a cloud can be read from its database: 'alidade sql load' has stored it, and no field
/// changes its points. Errors: those of opening a table on a server.
bool has_parts(const CloudInput& input);

/// The unit of parts of a cloud in a database: "chunks" of SQLite, "points" of a server.
const char* part_unit(const CloudInput& input);

/// Reads those points of a cloud in a database that are needed: at least all for which a filter holds
/// (database/sqlite/stored_cloud.h, database/server/server_clouds.h). Requires has_parts(input).
database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress);

}  // namespace alidade::jobs
