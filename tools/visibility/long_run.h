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

/// Whether and where to keep what is finished of a long run.
struct CheckpointRequest {
  std::optional<Options> command{};  ///< whose options were declared
  std::filesystem::path file;        ///< --checkpoint; empty: nothing is kept
  double interval = 60.0;            ///< --checkpoint-interval, seconds
  bool resume = false;               ///< --resume
};

/// Declares the options of a command, in a group of their own; they fill `request`.
void add_checkpoint_options(const Options& command, CheckpointRequest& request);

/// Lets a run fail before it starts. Errors: the checkpoint is one of the outputs or inputs, exists and may
/// neither be gone on from nor replaced, is another kind of file, or cannot be written.
void check_checkpoint(const CheckpointRequest& request, bool overwrite,
                      std::span<const std::filesystem::path> outputs,
                      std::span<const std::filesystem::path> inputs);

/// What the answers of a command depend on: its name, all its options but those that cannot change them
/// (outputs, threads, and how it is watched), the points, surfaces, classes and reference system of the cloud
/// as it was loaded; and on observers as they are placed. Requires that the options were read. Cost: the cloud is read
/// once.
Identity run_identity(const CheckpointRequest& request, const VisibilityCloud& cloud);
Identity run_identity(const CheckpointRequest& request, const VisibilityCloud& cloud,
                      std::span<const visibility::Observer> observers);

/// Adds the cells of a map.
void add_to_identity(const geo::RasterGrid& grid, Identity& identity);

/// The same for numbers of any other kind; `name` is how a message calls them.
void add_to_identity(const std::string& name, std::span<const double> numbers, Identity& identity);

/// A run that keeps what is finished, if that is wanted.
///
///   LongRun run(command.checkpoint, [&] { return run_identity(...); }, verbosity);
///   options.parts = run.parts();
///   options.progress = run.progress(line);
///   ... compute, write ...
///   run.finish();
class LongRun {
 public:
  /// Says whether it goes on from something. `identity` is asked only if a checkpoint is wanted: it reads the
  /// whole cloud. Errors: those of FinishedParts.
  LongRun(const CheckpointRequest& request, const std::function<Identity()>& identity, Verbosity verbosity);
  /// Says how to go on if the run was not finished.
  ~LongRun();
  LongRun(const LongRun&) = delete;
  LongRun& operator=(const LongRun&) = delete;

  /// Null if nothing is kept.
  FinishedParts* parts() { return parts_ ? &*parts_ : nullptr; }
  /// The line's callback, for which parts that were there count as done, but not for the rate. Valid as long
  /// as both objects.
  Progress progress(ProgressLine& line);
  /// Removes the checkpoint: everything is written.
  void finish();

 private:
  Verbosity verbosity_;
  std::optional<FinishedParts> parts_;
};

}  // namespace alidade::tools
