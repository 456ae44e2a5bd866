// SPDX-License-Identifier: MIT
#include "tools/commands.h"

namespace alidade {

Command add_visibility(CLI::App& program, const CommandLine& command_line) {
  CLI::App* const visibility =
      program.add_subcommand("visibility", "Find what is seen from where, on the cloud itself");
  visibility->require_subcommand(1);
  visibility->footer("'alidade visibility COMMAND --help' is the manual of a command.\n");
  const std::vector<Command> parts = {add_visibility_points(*visibility),
                                      add_visibility_raster(*visibility, command_line),
                                      add_visibility_horizon(*visibility, command_line),
                                      add_visibility_sky(*visibility, command_line),
                                      add_visibility_sun(*visibility, command_line),
                                      add_visibility_lines(*visibility, command_line),
                                      add_visibility_place(*visibility, command_line)};
  return {visibility, [parts] { return run_chosen(parts); }, parts};
}

}  // namespace alidade
