// SPDX-License-Identifier: MIT
#pragma once

#include "tools/command.h"

namespace alidade {

/// `alidade sql load`.
Command add_sql_load(CLI::App& sql);

}  // namespace alidade
