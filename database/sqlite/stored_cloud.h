// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"

// Clouds that store_cloud() wrote. Their names: "site.db", a file, or "site.db?table=NAME", a table of its;
// without a name it must be the only cloud in the file. Errors when opened: the file is no database; it has no
// cloud, several, or none of the name; what read_cloud_schema() says; more points than the file has room for.

namespace alidade::database {

/// Reads the points of those chunks of a cloud in SQLite that may hold one for which a filter holds, and so
/// at least all for which one does. `progress` is in chunks. Errors: those of opening it, ChunkStore's; two
/// points with one id. Cost: each filter is tested against boxes of chunks, level by level; the chunks.
CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress = {});

/// Points come back in the rows they had, with all attributes. Errors when read: ChunkStore's; ids that are no
/// rows.
extern const CloudFormat k_sqlite_format;

}  // namespace alidade::database
