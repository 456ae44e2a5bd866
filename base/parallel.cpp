// SPDX-License-Identifier: MIT
#include "base/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <exception>
#include <memory>
#include <mutex>

namespace alidade {

void detail::run_in_blocks(std::size_t count, std::size_t size, std::size_t most_threads, BlockWork run,
                           const void* work) {
  assert(size > 0);
  const std::size_t block_count = count / size + (count % size != 0);
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;  // of the two below
  std::size_t first_failed = block_count;
  std::exception_ptr failure;
  const auto run_blocks = [&](std::size_t) {
    for (std::size_t block = next++; block < block_count; block = next++) {
      try {
        run(work, block * size, std::min(count - block * size, size) + block * size);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (block < first_failed) failure = std::current_exception();
        first_failed = std::min(first_failed, block);
        next = block_count;
      }
    }
  };
  const std::size_t loops = std::min({block_count, most_threads, thread_count()});
  // Calling for other threads takes longer than a small block.
  if (loops <= 1)
    run_blocks(0);
  else
    tbb::parallel_for(std::size_t{0}, loops, run_blocks, tbb::simple_partitioner());
  if (failure) std::rethrow_exception(failure);
}

std::size_t thread_count() {
  return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
}

void PieceSize::learn(std::size_t items, Clock::duration time, std::size_t most) {
  const std::chrono::duration<double> taken = std::max<Clock::duration>(time, std::chrono::microseconds(1));
  const double in_time = static_cast<double>(items) * (limits_.wanted / taken);
  // Few enough for a double to hold.
  const std::size_t upper = std::min({4 * items_, limits_.most, most});
  const std::size_t wanted = in_time < static_cast<double>(upper) ? static_cast<std::size_t>(in_time) : upper;
  items_ = std::max(wanted, limits_.least);
}

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
  done_ += bytes;
  // Without more bytes it is asked whether to go on.
  bool is_due = bytes == 0;
  while (!is_stopped_ && (is_due || reported_ < done_) && !is_reporting_.exchange(true)) {
    const std::shared_ptr<void> end(nullptr, [&](void*) { is_reporting_ = false; });
    // Another thread may have reported these bytes, or stopped, until a moment ago.
    const std::uint64_t done = done_;
    if (!is_stopped_ && (is_due || reported_ < done)) {
      reported_ = done;
      is_stopped_ = !progress_(std::min(done, total_), total_);
    }
    is_due = false;
  }
  return !is_stopped_;
}

}  // namespace alidade
