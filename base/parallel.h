// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/progress.h"

namespace alidade {

namespace detail {

inline constexpr std::size_t k_all_threads = std::numeric_limits<std::size_t>::max();

using BlockWork = void (*)(const void* work, std::size_t first, std::size_t end);

void run_in_blocks(std::size_t count, std::size_t size, std::size_t most_threads, BlockWork run,
                   const void* work);

template <class Work>
void run_in_blocks(std::size_t count, std::size_t size, std::size_t most_threads, const Work& work) {
  const BlockWork run = [](const void* callee, std::size_t first, std::size_t end) {
    (*static_cast<const Work*>(callee))(first, end);
  };
  run_in_blocks(count, size, most_threads, run, &work);
}

}  // namespace detail

/// Calls work(first, end) for blocks of `size` (at least 1) of the numbers below `count`, the last one maybe
/// smaller, in parallel. They begin in their order: a free thread takes the next.
/// Errors: what `work` throws for the first block for which it throws, whatever the number of threads, once
/// all blocks that were begun have ended; no further one is begun. Cost: some ten nanoseconds per block.
template <class Work>
void in_blocks(std::size_t count, std::size_t size, const Work& work) {
  detail::run_in_blocks(count, size, detail::k_all_threads, work);
}

/// Calls work(i) for every i in [0, count), in blocks of `grain`, at most `most_threads` of them at once: as
/// in_blocks(). Work of less than a microsecond should have a grain of some hundred.
template <class Index, class Work>
void in_parallel(Index count, std::size_t grain, std::size_t most_threads, const Work& work) {
  const auto run = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i != end; ++i) work(static_cast<Index>(i));
  };
  detail::run_in_blocks(static_cast<std::size_t>(count), grain, most_threads, run);
}
template <class Index, class Work>
void in_parallel(Index count, std::size_t grain, const Work& work) {
  in_parallel(count, grain, detail::k_all_threads, work);
}

/// The number of threads that these loops use here.
std::size_t thread_count();

/// How many items the next piece of a long work has, so that a piece takes about the wanted time: between
/// pieces progress is reported, and the work can be cancelled. Thread safety: full.
class PieceSize {
 public:
  using Clock = std::chrono::steady_clock;

  struct Limits {
    std::size_t first = 1;  ///< items of the first piece
    std::size_t least = 1, most = std::numeric_limits<std::size_t>::max();
    std::chrono::milliseconds wanted{100};
  };

  explicit PieceSize(const Limits& limits) : limits_(limits), items_(limits.first) {}

  std::size_t next() const { return items_; }

  /// Adapts the size to the time that a piece of so many items, at least one, took. It grows at most
  /// fourfold, and to at most `most`.
  void learn(std::size_t items, Clock::duration time,
             std::size_t most = std::numeric_limits<std::size_t>::max());

 private:
  const Limits limits_;
  std::atomic<std::size_t> items_;
};

/// The progress of work that several threads do at once, on files or on parts of one: the sum of their bytes,
/// at most `total`. `progress` is never called by two threads at once, and not again once it has returned
/// false. No thread waits for another's report: Python runs handlers of signals there, which may do such work.
class JoinedProgress {
 public:
  /// `progress` must outlive the object, which must outlive the passes.
  JoinedProgress(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  /// The callback for a pass over `bytes` bytes, which makes one call at a time.
  Progress pass(std::uint64_t bytes);

  /// Adds bytes that are done, maybe none. Errors: Cancelled, once `progress` has returned false.
  void add(std::uint64_t bytes);

 private:
  bool count(std::uint64_t bytes);

  const Progress& progress_;
  const std::uint64_t total_;
  std::atomic<std::uint64_t> done_ = 0, reported_ = 0;
  std::atomic<bool> is_reporting_ = false, is_stopped_ = false;
};

}  // namespace alidade
