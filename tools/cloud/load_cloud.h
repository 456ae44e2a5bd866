// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "base/progress.h"
#include "database/point_filter.h"

namespace alidade::tools {

/// Whether it is a cloud in a database that can be asked for a part of it: one that 'alidade sql load' made.
/// Errors: those of opening a table on a server.
bool has_parts(const std::filesystem::path& name);

/// What such parts consist of: "chunks" of SQLite, "points" of a server.
const char* part_unit(const std::filesystem::path& name);

/// Reads those points of a cloud in a database that are needed: at least all for which a filter holds
/// (database/sqlite/stored_cloud.h, database/server/read_server.h). Requires has_parts(name).
database::CloudPart read_database_part(const std::filesystem::path& name,
                                       std::span<const database::PointFilter> any_of, AttributeSet attributes,
                                       const Progress& progress);

/// "chunks read" or "points read", as a line of a table.
std::string part_table(const database::CloudPart& part);

}  // namespace alidade::tools
