// SPDX-License-Identifier: MIT
#include "tools/cloud_options.h"

#include "cloud/cloud_inputs.h"

namespace alidade {

CLI::Option* add_cloud_files(CLI::App& command, const std::string& name,
                             std::vector<std::filesystem::path>& files, const std::string& help) {
  return command.add_option_function<std::vector<std::string>>(
      name,
      [&files](const std::vector<std::string>& words) {
        files = expand_cloud_files(std::vector<std::filesystem::path>(words.begin(), words.end()));
      },
      help);
}

CLI::Option* add_partial(CLI::App& command, bool& partial) {
  return command
      .add_flag("--partial", partial,
                "read what is whole of damaged files, and say what is lost; without it they are errors")
      ->option_text(" ");
}

}  // namespace alidade
