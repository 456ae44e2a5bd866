// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "base/progress.h"
#include "database/cloud_part.h"
#include "database/point_filter.h"

namespace alidade {

/// Reads the points of those chunks of a cloud in SQLite that may hold one for which a filter holds, and so
/// at least all for which one does. `progress` is in chunks. Errors: StoredCloud's and ChunkStore's; two
/// points with one id. Cost: each filter is tested against boxes of chunks, level by level; the chunks.
CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress = {});

}  // namespace alidade
