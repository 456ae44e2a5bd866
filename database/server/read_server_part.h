// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "base/progress.h"
#include "database/cloud_part.h"
#include "database/point_filter.h"

namespace alidade {

/// Reads those points of a table on a server (ServerName) for which one of the filters may hold: at least all
/// for which one does. The server finds them by its index; it would try more than 64 on too many points, and
/// then all are read. Requires a table with its NAME_cloud. `progress` is in points, of all. Errors: those of
/// server_clouds(); ids that are there twice.
CloudPart read_server_part(const std::string& name, std::span<const PointFilter> any_of,
                           AttributeSet attributes, const Progress& progress = {});

/// Whether a part can be read of the table: it has its NAME_cloud. Errors: those of opening it.
bool has_server_parts(const std::string& name);

}  // namespace alidade
