// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "octree/tree_query.h"
#include "tools/query/target_kind.h"

namespace alidade {

/// What --explain says: the work of a run in all and for each target.
std::string explain_table(const QueryStatistics& statistics, const TargetKind& kind, std::uint64_t targets,
                          std::uint64_t answers);

}  // namespace alidade
