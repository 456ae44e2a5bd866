// SPDX-License-Identifier: MIT
#include "base/parallel.h"

#include <algorithm>
#include <memory>

namespace alidade {

Progress JoinedProgress::pass(std::uint64_t bytes) {
  if (!progress_) return {};
  // Shared, because functions are copied.
  return [this, bytes, before = std::make_shared<std::uint64_t>(0)](std::uint64_t done, std::uint64_t) {
    const std::uint64_t now = std::max(std::min(done, bytes), *before);
    const std::uint64_t more = now - *before;
    *before = now;
    return count(more);
  };
}

void JoinedProgress::add(std::uint64_t bytes) {
  if (progress_ && !count(bytes)) throw Cancelled();
}

bool JoinedProgress::count(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  done_ = std::min(done_ + bytes, total_);
  if (!is_stopped_) is_stopped_ = !progress_(done_, total_);
  return !is_stopped_;
}

}  // namespace alidade
