// SPDX-License-Identifier: MIT
#pragma once

#include "tools/command.h"

// The commands of `alidade visibility`.

namespace alidade {

Command add_visibility_lines(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_place(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_points(CLI::App& visibility);
Command add_visibility_raster(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_horizon(CLI::App& visibility, const CommandLine& words);
Command add_visibility_sky(CLI::App& visibility, const CommandLine& words);
Command add_visibility_sun(CLI::App& visibility, const CommandLine& words);

}  // namespace alidade
