// SPDX-License-Identifier: MIT
#include "jobs/query/targets.h"

#include <gtest/gtest.h>

namespace alidade::test {

namespace {

PieceSize::Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<PieceSize::Clock::duration>(std::chrono::duration<double>(seconds));
}

/// The size after many batches of targets that have so many answers and take so many seconds each.
std::size_t size_after_batches(double answers, double seconds) {
  jobs::BatchSize size;
  for (int batch = 0; batch < 20; ++batch) {
    const auto targets = static_cast<double>(size.targets());
    size.learn(size.targets(), static_cast<std::size_t>(targets * answers), duration(targets * seconds));
  }
  return size.targets();
}

TEST(BatchSize, light_targets_are_queried_by_the_ten_thousand) {
  EXPECT_EQ(size_after_batches(1, 1e-7), 1u << 15);
}

TEST(BatchSize, batches_of_heavy_targets_end_within_a_fifth_of_a_second) {
  for (const double seconds : {1e-5, 1e-4, 1e-3, 1e-2}) {
    const auto targets = static_cast<double>(size_after_batches(1, seconds));
    EXPECT_LE(targets * seconds, 0.2001);
    EXPECT_GE(targets * seconds, 0.1);
  }
  EXPECT_EQ(size_after_batches(1, 60.0), 8u);
}

TEST(BatchSize, first_batch_is_small_and_the_next_ones_grow_fourfold_at_most) {
  jobs::BatchSize size;
  EXPECT_EQ(size.targets(), 32u);
  size.learn(32, 0, duration(0.0));
  EXPECT_EQ(size.targets(), 128u);
  size.learn(128, 0, duration(30.0));
  EXPECT_EQ(size.targets(), 8u);
  size.learn(8, 0, duration(0.0));
  EXPECT_EQ(size.targets(), 32u);
}

TEST(BatchSize, answers_of_a_batch_are_few_enough_to_hold) {
  for (const double answers : {0.0, 1.0, 1e3, 1e5, 1e9}) {
    jobs::BatchSize size;
    for (int batch = 0; batch < 20; ++batch) {
      EXPECT_LE(size.targets() * size.answers_per_target(), 1u << 20);
      size.learn(size.targets(), static_cast<std::size_t>(answers * static_cast<double>(size.targets())),
                 duration(1e-3));
    }
  }
}

}  // namespace
}  // namespace alidade::test
