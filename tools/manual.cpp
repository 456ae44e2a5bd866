// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "base/error.h"
#include "base/output_file.h"
#include "tools/command.h"
#include "tools/manual_page.h"

namespace alidade::tools {
namespace {

struct ManualCommand : RunRequest {
  std::optional<Options> program{};  ///< whose manual it is
  std::filesystem::path folder;
  bool overwrite = false;
};

ExitCode run(const ManualCommand& command) {
  const auto files = manual_files(command.program->entry(), ALIDADE_VERSION);
  for (const auto& [name, text] : files) {
    const std::filesystem::path folder = (command.folder / name).parent_path();
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw system_error(folder.string(), "cannot make the folder", error.value());
    check_output(command.folder / name, command.overwrite);
  }
  for (const auto& [name, text] : files) write_text_file(command.folder / name, text, command.overwrite);
  say_note(command.verbosity, fmt::format("wrote {} files to {}", files.size(), command.folder.string()));
  return ExitCode::done;
}

}  // namespace

Command add_manual(const Options& program) {
  auto command = std::make_shared<ManualCommand>();
  command->program = program;
  const Options manual =
      program.command("manual", "Write manual pages, and completions for bash, zsh and fish");
  manual.required().file("folder", "FOLDER", "folder of shared data, created if missing", command->folder);
  manual.flag("--overwrite", "replace existing files", command->overwrite);
  add_verbosity(manual, command->verbosity);
  return command_of(manual, command, run);
}

}  // namespace alidade::tools
