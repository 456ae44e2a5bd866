// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/checkpoint.h"
#include "base/error.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// Whether and where to save finished work of a long run.
struct CheckpointRequest {
  std::optional<Fields> fields{};  ///< of the request, to which those below belong
  std::filesystem::path file;      ///< --checkpoint; empty: nothing is kept
  double interval = 60.0;          ///< --checkpoint-interval, seconds
  bool resume = false;             ///< --resume
};

/// Declares --checkpoint, --checkpoint-interval and --resume. For the manual: `when` a checkpoint is written,
/// what the job writes, and whether a checkpoint is a FILE or a FOLDER.
void add_checkpoint_fields(const Fields& fields, CheckpointRequest& request,
                           const std::string& when = "every --checkpoint-interval seconds",
                           const std::string& output = "output", const std::string& kind = "FILE");

/// "; wrote FILE", the end of a job's last note; nothing without an output.
std::string wrote_text(const JobRequest& request);

/// Lets a run fail before it starts, and adds the checkpoint to what it writes. Errors: the checkpoint is one
/// of the outputs or inputs, exists and may neither be resumed from nor replaced, is another kind of file, by
/// `is_kind`, than `kind`, or cannot be written; a run in parts has no fields to resume by.
void check_checkpoint(const CheckpointRequest& request, bool overwrite, PlannedWork& work,
                      bool (*is_kind)(const std::filesystem::path&) = is_parts_file,
                      const char* kind = "a visibility checkpoint");

/// Warns of the first checkpoint that cannot be written: the next ones will probably fail like it. The
/// listener must live as long as the result.
std::function<void(const Error&)> checkpoint_warning(Listener& listener);

/// "no checkpoint FILE: starting from the beginning".
std::string beginning_text(const CheckpointRequest& request);

/// Notes how to resume after an interruption.
void say_how_to_resume(Listener& listener, const std::string& checkpoint);

// Fields, common to several requests, that cannot change answers: how a job runs, what it says, and where it
// writes.

inline constexpr std::array<std::string_view, 8> k_silent_flags = {
    "help", "overwrite", "skip-existing", "quiet", "verbose", "resume", "dry-run", "yes"};

/// Fields with a value.
inline constexpr std::array<std::string_view, 8> k_silent_options = {
    "output", "threads", "memory", "cache", "cache-size", "allow-host", "checkpoint", "checkpoint-interval"};

/// Whether the field of this name, without hyphens, is one of these, or of those that a job adds to them.
inline bool is_silent(std::string_view name, std::span<const std::string_view> own) {
  const auto has = [name](std::span<const std::string_view> names) {
    return std::ranges::find(names, name) != names.end();
  };
  return has(k_silent_flags) || has(k_silent_options) || has(own);
}

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

  /// Removes the checkpoint: everything is written, or returned.
  void finish();

 private:
  Progress progress(Listener::Stage& stage);

  Listener& listener_;
  std::optional<PartCheckpoint> parts_;
};

}  // namespace alidade::jobs
