// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <span>

namespace alidade {

/// Whether and where to keep what is finished of a long run.
struct CheckpointRequest {
  std::filesystem::path file;  ///< --checkpoint; empty: nothing is kept
  double interval = 60.0;      ///< --checkpoint-interval, seconds
  bool resume = false;         ///< --resume
};

/// Declares the options in a group of their own; they fill `request`.
void add_checkpoint_options(CLI::App& command, CheckpointRequest& request);

/// Lets a run fail before it starts. Errors: the checkpoint is one of the outputs or inputs, exists and may
/// neither be gone on from nor replaced, is another kind of file, or cannot be written.
void check_checkpoint(const CheckpointRequest& request, bool overwrite,
                      std::span<const std::filesystem::path> outputs,
                      std::span<const std::filesystem::path> inputs);

}  // namespace alidade
