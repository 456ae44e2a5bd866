// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>

#include "base/scratch_checkpoint.h"
#include "cloud/cloud_inputs.h"
#include "tools/console.h"
#include "tools/options.h"

// Reading a cloud that memory does not hold, which can be resumed (ScratchCloud).

namespace alidade::tools {

/// Lets a run fail before it starts. Errors: the checkpoint is or holds the output, holds an input, exists
/// and may neither be resumed from nor replaced, or is another folder; an input is a table of a database,
/// whose changes would not be detected.
void check_kept_reading(const CheckpointRequest& request, bool overwrite, const std::filesystem::path& output,
                        const CloudInputs& inputs);

/// The checkpoint of a reading, if one is requested. It is valid for the same files, by name, size and time
/// of the last change (remote ones: the server's version), the same version of the program, and the same
/// options but for threads, memory, and names of outputs.
class KeptReading {
 public:
  /// Prints what it resumes from. Errors: those of ScratchCheckpoint.
  KeptReading(const CheckpointRequest& request, const CloudInputs& inputs, Verbosity verbosity);
  /// Prints how to resume if the run was not finished; removes a checkpoint without points.
  ~KeptReading();
  KeptReading(const KeptReading&) = delete;
  KeptReading& operator=(const KeptReading&) = delete;

  /// Null if none is requested.
  ScratchCheckpoint* checkpoint() { return checkpoint_ ? &*checkpoint_ : nullptr; }
  /// Removes the checkpoint: the output is written.
  void finish();

 private:
  Verbosity verbosity_;
  std::optional<ScratchCheckpoint> checkpoint_;
};

}  // namespace alidade::tools
