// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <type_traits>
#include <vector>

#include "base/progress.h"

namespace alidade {

/// Calls work(i) for every i in [0, count), in parallel, at least half of `grain` of them one after another.
template <class Index, class Work>
void in_parallel(Index count, std::type_identity_t<Index> grain, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<Index>(0, count, grain), [&](const auto& range) {
    for (Index i = range.begin(); i != range.end(); ++i) work(i);
  });
}

/// Calls body(0) .. body(count - 1) in parallel, begun in this order: a free thread takes the next. For work
/// that uses up memory along the way and should have only a few parts of it in use at a time.
template <class Body>
void for_each_in_order(std::size_t count, const Body& body) {
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) {
    for (std::size_t i = next++; i < count; i = next++) body(i);
  });
}

/// Calls work(i) for every i in [first, end), in parallel. If some of them throw, the exception of the
/// smallest i is thrown on when all that were begun have ended, whatever the number of threads.
template <class Work>
void at_once(std::size_t first, std::size_t end, const Work& work) {
  std::vector<std::exception_ptr> failures(end - first);
  std::atomic<std::size_t> first_failed = end;
  tbb::parallel_for(
      first, end,
      [&](std::size_t i) {
        if (i > first_failed.load()) return;
        try {
          work(i);
        } catch (...) {
          failures[i - first] = std::current_exception();
          std::size_t known = first_failed.load();
          while (i < known && !first_failed.compare_exchange_weak(known, i)) {
          }
        }
      },
      tbb::simple_partitioner());
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

/// Calls work(i) for every i in [0, count) as at_once(), `most` calls at a time, each lot when the one before
/// it has ended.
template <class Work>
void in_turns(std::size_t count, std::size_t most, const Work& work) {
  for (std::size_t first = 0; first < count; first += most)
    at_once(first, count - first < most ? count : first + most, work);
}

/// The progress of work that several threads do at once, on files or on parts of one: the sum of their bytes,
/// at most `total`. `progress` is never called by two threads at once, and not again once it has returned
/// false.
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
  std::mutex mutex_;
  std::uint64_t done_ = 0;
  bool is_stopped_ = false;
};

}  // namespace alidade
