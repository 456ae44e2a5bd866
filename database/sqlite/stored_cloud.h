// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"

// Clouds that store_cloud() wrote. Their names are "site.db", a file that contains one cloud, or
// "site.db?table=NAME", a cloud in it. Errors when opened: the file is not a database; it contains no cloud,
// several, or none of that name; those of read_cloud_schema(); more points than the size of the file allows.

namespace alidade::database {

/// Reads the points of those chunks of a cloud in SQLite that may have points for which one of the filters
/// holds: at least all such points. `progress` is in chunks. Errors: those of opening it, ChunkStore's; two
/// points with one id. Cost: each filter is tested against boxes of chunks, level by level; the chunks.
CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress = {});

/// Points have the rows and attributes that they had when they were stored. Errors when read: ChunkStore's;
/// ids that are not row numbers.
extern const CloudFormat k_sqlite_format;

}  // namespace alidade::database
