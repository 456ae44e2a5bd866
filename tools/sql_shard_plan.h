// SPDX-License-Identifier: MIT
#pragma once

#include "tools/command.h"

namespace alidade {

/// `alidade sql load`.
Command add_sql_shard_plan(CLI::App& sql);

}  // namespace alidade
