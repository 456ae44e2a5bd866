// SPDX-License-Identifier: MIT
#include "tools/visibility/checkpoint_options.h"

#include "base/checkpoint.h"
#include "base/error.h"
#include "tools/options.h"

namespace alidade {

void add_checkpoint_options(CLI::App& command, CheckpointRequest& request) {
  constexpr double k_most_seconds = 1e9;
  const char* const group = "Long runs";
  CLI::Option* const checkpoint =
      add_value(
          command, "--checkpoint", "FILE",
          "keep what has been computed in FILE, every --checkpoint-interval seconds and on Ctrl-C; removed "
          "once the output is written",
          [&request](const std::string& text) { request.file = text; })
          ->group(group);
  add_value(
      command, "--checkpoint-interval", "S", "seconds between checkpoints, above 0 (default 60)",
      [&request](const std::string& text) { request.interval = parse_number(text, 1e-3, k_most_seconds); })
      ->needs(checkpoint)
      ->group(group);
  command
      .add_flag("--resume", request.resume,
                "go on from the checkpoint, if it is there; the output has the bytes of an uninterrupted run")
      ->option_text(" ")
      ->needs(checkpoint)
      ->group(group);
}

void check_checkpoint(const CheckpointRequest& request, bool overwrite,
                      std::span<const std::filesystem::path> outputs,
                      std::span<const std::filesystem::path> inputs) {
  if (request.file.empty()) return;
  std::error_code error;
  for (const std::filesystem::path& output : outputs) {
    if (!output.empty() && same_file(request.file, output)) {
      throw Error(
          {.file = request.file.string(), .problem = "is an output to write", .expected = "another name"});
    }
  }
  const bool is_there = std::filesystem::exists(request.file, error);
  if (is_there && !request.resume && !overwrite) {
    throw Error({.file = request.file.string(),
                 .problem = "exists already",
                 .expected = "--resume to go on from it, or --overwrite"});
  }
  check_writable(request.file, true, inputs);
  // It would be replaced, and removed in the end.
  if (is_there && !is_parts_file(request.file)) {
    throw Error({.file = request.file.string(),
                 .place = "byte 0",
                 .problem = "is not a checkpoint of such a run",
                 .expected = "a checkpoint, or the name of a file that does not exist"});
  }
}

}  // namespace alidade
