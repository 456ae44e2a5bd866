// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/input_file.h"

namespace alidade {

constexpr std::uint64_t k_fault_page = 4096;  ///< bytes

/// Memory whose pages are filled when a thread first touches them: the thread waits until another thread has
/// filled the page (userfaultfd(2)).
class PageFaults {
 public:
  /// Begins to report the missing pages of this anonymous map. False if the system does not permit that:
  /// Linux before 5.11, and some containers.
  bool open(std::span<std::byte> map);

  /// Waits for a thread that touches a missing page. Returns its address, or null after stop(). Several
  /// threads may wait; more than one may get the same page.
  const std::byte* next();
  /// Ends all calls of next().
  void stop();

  /// Fills whole pages with the bytes at `from`, or with zeros if it is null, and wakes the threads that wait
  /// for them. Pages that are filled already stay as they are.
  void fill(std::span<std::byte> pages, const std::byte* from);
  /// Wakes the threads that wait for a page that is filled.
  void wake(const std::byte* page);

 private:
  FileDescriptor faults_, stop_;
  std::atomic<bool> is_stopping_ = false;
};

}  // namespace alidade
