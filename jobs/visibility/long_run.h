// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/checkpoint.h"
#include "geo/raster.h"
#include "jobs/checkpoint_request.h"
#include "jobs/listener.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// "; wrote FILE", the end of a job's last note; nothing without an output.
std::string wrote_text(const JobRequest& request);

/// Lets a run fail before it starts, and adds the checkpoint to what it writes. Errors: the request has no
/// fields to resume by; the checkpoint is one of the outputs or inputs, exists and may neither be resumed
/// from nor replaced, is another kind of file, or cannot be written.
void check_checkpoint(const CheckpointRequest& request, bool overwrite, PlannedWork& work);

/// All that the answers of a job depend on: its name, the fields given to it without those that cannot change
/// answers (outputs, threads, messages), the points, surfaces, classes and reference system of the cloud as
/// it was loaded; and the observers where they were placed. Requires that the fields were read. Cost: the
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
///   LongRun run(request.checkpoint, [&] { return run_fingerprint(...); }, listener);
///   run.work("testing the sky", "cells",
///            [&](const Progress& progress, PartCheckpoint* parts) { return ...; });
///   ... write ...
///   run.finish();
class LongRun {
 public:
  /// Notes what the run resumes from. `fingerprint`, which reads the whole cloud, is called only if a
  /// checkpoint is requested. Errors: those of PartCheckpoint.
  LongRun(const CheckpointRequest& request, const std::function<Fingerprint()>& fingerprint,
          Listener& listener);
  /// With run_fingerprint() of the cloud and the observers.
  LongRun(const CheckpointRequest& request, const VisibilityCloud& cloud,
          std::span<const visibility::Observer> observers, Listener& listener);
  /// Notes how to resume if the run was not finished.
  ~LongRun();
  LongRun(const LongRun&) = delete;
  LongRun& operator=(const LongRun&) = delete;

  /// Returns what compute(progress, parts) returns, as one stage. Parts of the checkpoint count as done, but
  /// not for the rate. `parts` is null without a checkpoint.
  template <class Compute>
  auto work(const std::string& task, const std::string& unit, const Compute& compute) {
    const std::unique_ptr<Listener::Stage> stage = listener_.begin(task, unit);
    auto result = compute(progress(*stage), parts_ ? &*parts_ : nullptr);
    stage->finish();
    return result;
  }

  /// work() that follows lines of sight by a function of the library: test(options), whose options have
  /// `progress` and `parts`.
  template <class Options, class Test>
  auto test_visibility(Options options, const Test& test) {
    return work("testing visibility", "lines of sight", [&](const Progress& progress, PartCheckpoint* parts) {
      options.progress = progress;
      options.parts = parts;
      return test(options);
    });
  }

  /// Removes the checkpoint: everything is written, or returned. Errors: those of RemoteMap::check_all().
  void finish();

 private:
  Progress progress(Listener::Stage& stage);

  Listener& listener_;
  std::optional<PartCheckpoint> parts_;
};

}  // namespace alidade::jobs
