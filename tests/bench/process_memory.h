// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <fstream>
#include <string>

namespace alidade::bench {

/// What Linux counts as this process's memory in RAM, bytes.
struct ProcessMemory {
  std::size_t resident = 0;
  std::size_t peak = 0;  ///< since the start or since forget_peak()
};

inline ProcessMemory process_memory() {
  ProcessMemory memory;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == "VmRSS:") status >> memory.resident;
    if (word == "VmHWM:") status >> memory.peak;
  }
  return {memory.resident * 1024, memory.peak * 1024};
}

inline void forget_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace alidade::bench
