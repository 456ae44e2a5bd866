// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <mutex>

#include "base/progress.h"

namespace alidade {

/// The progress of work that several threads do at once, on files or on parts of one: the sum of their bytes,
/// at most `total`. Whoever watches is never called by two threads at once, and after the answer to stop not
/// again.
class JoinedProgress {
 public:
  /// `progress` must outlive the object, which must outlive the passes.
  JoinedProgress(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  /// What to give to a pass over `bytes` bytes, which reports to it one call at a time.
  Progress pass(std::uint64_t bytes);

  /// So many bytes more, maybe none, are done. Errors: Cancelled, when the answer was to stop.
  void add(std::uint64_t bytes);

 private:
  bool count(std::uint64_t bytes);

  const Progress& progress_;
  const std::uint64_t total_;
  std::mutex mutex_;
  std::uint64_t done_ = 0;
  bool is_stopped_ = false;
};

}  // namespace alidade
