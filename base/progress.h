// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>

#include "base/error.h"

namespace alidade {

/// Reports the progress of a long task, in units of its own (points, pixels, bytes).
/// Called dozens of times per second, of batches on many threads thousands of times, so that whatever takes
/// long should look at the clock; never by two threads at once. Returning false stops the task, which then
/// cleans up and throws Cancelled. With an empty function nothing is reported.
using Progress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

/// Reports to `progress` if there is one; throws Cancelled if it returns false.
inline void report(const Progress& progress, std::uint64_t done, std::uint64_t total) {
  if (progress && !progress(done, total)) throw Cancelled();
}

}  // namespace alidade
