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
#include "jobs/cloud_part.h"
#include "jobs/load_cloud.h"
#include "octree/index_file/index_file.h"
#include "tools/options.h"

namespace alidade::tools {

using jobs::add_scratch_memory;
using jobs::check_map_unit;
using jobs::cloud_formats;
using jobs::has_parts;
using jobs::part_unit;
using jobs::read_database_part;
using jobs::scratch_beside;

/// jobs::load_cloud() for a command, with its messages.
IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options);

/// "chunks read" or "points read", as a line of a table.
std::string part_table(const database::CloudPart& part);

}  // namespace alidade::tools
