// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tools/command.h"

namespace alidade {

/// The command line as metadata keep it: without the words that only say where the picture goes, how it is
/// computed and who watches, so that the same picture is the same file.
std::string picture_command(const CommandLine& words);

}  // namespace alidade
