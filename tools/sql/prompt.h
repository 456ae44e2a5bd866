// SPDX-License-Identifier: MIT
#pragma once

#include "tools/sql/run_statements.h"

namespace alidade {

/// Asks for statements at the terminal and runs them until its end or .quit. A statement ends with a
/// semicolon and may take several lines; a line that begins with a dot is a command of the prompt (.help).
/// Errors are told, and it goes on; so it does after Ctrl-C, which drops what is typed or runs. Other signals
/// are thrown as Cancelled.
void run_prompt(const Connection& connection, const std::string& database, SqlRun run);

}  // namespace alidade
