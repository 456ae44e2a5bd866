// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "base/checkpoint.h"
#include "geo/raster.h"
#include "tools/console.h"
#include "tools/options.h"
#include "tools/visibility/blocking_cloud.h"
#include "visibility/observers.h"

namespace alidade::tools {

/// Lets a run fail before it starts. Errors: the checkpoint is one of the outputs or inputs, exists and may
/// neither be resumed from nor replaced, is another kind of file, or cannot be written.
void check_checkpoint(const CheckpointRequest& request, bool overwrite,
                      std::span<const std::filesystem::path> outputs,
                      std::span<const std::filesystem::path> inputs);

/// All that the answers of a command depend on: its name, its options without those that cannot change
/// answers (outputs, threads, messages), the points, surfaces, classes and reference system of the cloud as
/// it was loaded; and the observers where they were placed. Requires that the options were read. Cost: the
/// cloud is read once.
Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud);
Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud,
                            std::span<const visibility::Observer> observers);

/// Adds the cells of a map.
void add_to_fingerprint(const geo::RasterGrid& grid, Fingerprint& fingerprint);

/// Adds other numbers, which messages call `name`.
void add_to_fingerprint(const std::string& name, std::span<const double> numbers, Fingerprint& fingerprint);

/// A run with a checkpoint of its finished parts, if one is requested.
///
///   LongRun run(command.checkpoint, [&] { return run_fingerprint(...); }, verbosity);
///   run.work("testing visibility", "lines of sight",
///            [&](const Progress& progress, PartCheckpoint* parts) { return ...; });
///   ... write ...
///   run.finish();
class LongRun {
 public:
  /// Prints what the run resumes from. `fingerprint`, which reads the whole cloud, is called only if a
  /// checkpoint is requested. Errors: those of PartCheckpoint.
  LongRun(const CheckpointRequest& request, const std::function<Fingerprint()>& fingerprint,
          Verbosity verbosity);
  /// Prints how to resume if the run was not finished.
  ~LongRun();
  LongRun(const LongRun&) = delete;
  LongRun& operator=(const LongRun&) = delete;

  /// Returns what compute(progress, parts) returns, with a ProgressLine around it. Parts of the checkpoint
  /// count as done, but not for the rate. `parts` is null without a checkpoint.
  template <class Compute>
  auto work(const std::string& task, const std::string& unit, const Compute& compute) {
    ProgressLine line(task, unit, verbosity_);
    auto result = compute(progress(line), parts_ ? &*parts_ : nullptr);
    line.finish();
    return result;
  }

  /// Removes the checkpoint: everything is written.
  void finish();

 private:
  Progress progress(ProgressLine& line);

  Verbosity verbosity_;
  std::optional<PartCheckpoint> parts_;
};

}  // namespace alidade::tools
