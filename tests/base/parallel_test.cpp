// SPDX-License-Identifier: MIT
#include "base/parallel.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/recently_used.h"

namespace alidade::test {
namespace {

TEST(Parallel, every_number_is_in_one_block) {
  for (const std::size_t count : {0, 1, 255, 256, 257, 10000}) {
    std::vector<std::atomic<int>> seen(count);
    in_blocks(count, 256, [&](std::size_t first, std::size_t end) {
      EXPECT_EQ(first % 256, 0u);
      EXPECT_EQ(end, std::min(first + 256, count));
      for (std::size_t i = first; i < end; ++i) ++seen[i];
    });
    in_parallel(static_cast<int>(count), 7, [&](int i) { ++seen[static_cast<std::size_t>(i)]; });
    for (const std::atomic<int>& times : seen) EXPECT_EQ(times, 2);
  }
}

TEST(Parallel, the_error_of_the_first_block_that_has_one_is_thrown) {
  for (int trial = 0; trial < 20; ++trial) {
    try {
      in_parallel(1000, 1, [](int i) {
        if (i >= 500) throw std::runtime_error(std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), std::string("500"));
    }
  }
}

TEST(Parallel, of_loops_in_a_loop_the_error_of_the_first_one_is_thrown) {
  for (int trial = 0; trial < 20; ++trial) {
    try {
      in_parallel(20, 1, [](int i) {
        in_parallel(20, 1, [i](int j) {
          if (i >= 7 && j >= 3) throw std::runtime_error(std::to_string(100 * i + j));
        });
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), std::string("703"));
    }
  }
}

TEST(Parallel, at_most_as_many_blocks_as_requested_run_at_once) {
  for (const int requested : {1, 2}) {
    std::atomic<int> running = 0, most = 0;
    in_parallel(40, 1, static_cast<std::size_t>(requested), [&](int) {
      const int now = ++running;
      for (int known = most; now > known && !most.compare_exchange_weak(known, now);) continue;
      // So long that blocks would overlap.
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --running;
    });
    EXPECT_LE(most, requested);
  }
}

TEST(JoinedProgress, of_many_threads_rises_to_the_total_and_is_told_by_one_at_a_time) {
  constexpr std::size_t k_items = 1'000'000;  // so that threads meet within a few instructions
  std::atomic<int> callers = 0;
  std::uint64_t last = 0;
  const Progress watch = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(++callers, 1);
    EXPECT_EQ(total, k_items);
    EXPECT_GT(done, last);
    last = done;
    --callers;
    return true;
  };
  JoinedProgress progress(watch, k_items);
  tbb::task_arena(4).execute([&] { in_parallel(k_items, 1, [&](std::size_t) { progress.add(1); }); });
  EXPECT_EQ(last, k_items);
}

TEST(JoinedProgress, is_not_told_again_once_it_has_stopped) {
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> calls = 0, stopped = 0;
    const Progress watch = [&](std::uint64_t, std::uint64_t) { return ++calls < 20; };
    JoinedProgress progress(watch, 1'000'000'000'000);
    tbb::task_arena(4).execute([&] {
      in_parallel(std::size_t{4}, 1, [&](std::size_t) {
        try {
          for (;;) progress.add(1);
        } catch (const Cancelled&) {
          ++stopped;
        }
      });
    });
    EXPECT_EQ(calls, 20);
    EXPECT_EQ(stopped, 4);
    EXPECT_THROW(progress.add(0), Cancelled);
  }
}

TEST(JoinedProgress, may_be_added_to_while_it_is_told) {
  constexpr std::uint64_t k_items = 1000;
  JoinedProgress* adds = nullptr;
  std::uint64_t last = 0;
  const Progress watch = [&](std::uint64_t done, std::uint64_t) {
    last = done;
    if (done < k_items) adds->add(1);
    return true;
  };
  JoinedProgress progress(watch, k_items);
  adds = &progress;
  // The reporting thread also reports what was added meanwhile.
  progress.add(1);
  EXPECT_EQ(last, k_items);
}

TEST(JoinedProgress, asks_whether_to_go_on_when_nothing_is_added) {
  int calls = 0;
  const Progress watch = [&](std::uint64_t, std::uint64_t) { return ++calls < 3; };
  JoinedProgress progress(watch, 10);
  progress.add(5);
  progress.add(0);
  EXPECT_EQ(calls, 2);
  EXPECT_THROW(progress.add(0), Cancelled);
}

TEST(PieceSize, follows_the_time_that_pieces_take) {
  using std::chrono::milliseconds;
  PieceSize size({.first = 100, .least = 10, .most = 1000, .wanted = milliseconds(100)});
  EXPECT_EQ(size.next(), 100u);
  size.learn(100, milliseconds(50));
  EXPECT_EQ(size.next(), 200u);
  size.learn(200, milliseconds(1));
  EXPECT_EQ(size.next(), 800u);
  size.learn(800, milliseconds(1));
  EXPECT_EQ(size.next(), 1000u);
  size.learn(1000, milliseconds(1000000));
  EXPECT_EQ(size.next(), 10u);
  size.learn(10, milliseconds(1), 20);
  EXPECT_EQ(size.next(), 20u);
}

TEST(RecentlyUsed, gives_up_what_was_used_least_recently) {
  RecentlyUsed<int, std::string> values;
  values.add(1, "one");
  values.add(2, "two");
  values.add(3, "three");
  EXPECT_EQ(*values.find(1), "one");
  EXPECT_EQ(values.find(4), nullptr);
  EXPECT_EQ(values.take_oldest(), "two");
  EXPECT_EQ(values.find(2), nullptr);
  EXPECT_EQ(values.take_oldest(), "three");
  EXPECT_EQ(values.size(), 1u);
  EXPECT_EQ(values.entries().front().first, 1);
}

}  // namespace
}  // namespace alidade::test
