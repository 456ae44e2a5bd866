// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "jobs/fields.h"
#include "jobs/listener.h"

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

/// Warns of the first checkpoint that cannot be written: the next ones will probably fail like it. The
/// listener must live as long as the result.
std::function<void(const Error&)> checkpoint_warning(Listener& listener);

/// Says how to resume after an interruption.
void say_how_to_resume(Listener& listener, const std::string& checkpoint);

// Fields, common to several requests, that cannot change answers: how a job runs, what it says, and where it
// writes.

inline constexpr std::array<std::string_view, 6> k_silent_flags = {"help",  "overwrite", "skip-existing",
                                                                   "quiet", "verbose",   "resume"};

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

}  // namespace alidade::jobs
