// SPDX-License-Identifier: MIT
#include "tools/console.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace alidade::test {

using namespace tools;

namespace {

/// What a task of a hundred reports leaves in a log.
std::string log_of_a_task(Verbosity verbosity) {
  ::testing::internal::CaptureStderr();
  {
    ProgressLine line("counting", "sheep", verbosity);
    const Progress progress = line.callback();
    for (std::uint64_t done = 0; done <= 100; ++done) EXPECT_TRUE(progress(done, 100));
    line.finish();
  }
  return ::testing::internal::GetCapturedStderr();
}

TEST(progress_line, a_short_task_is_one_line_in_a_log) {
  const std::string log = log_of_a_task(Verbosity::normal);
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_EQ(log.rfind("counting: 100 sheep in ", 0), 0u) << log;
  EXPECT_EQ(log.find('\r'), std::string::npos);
}

TEST(progress_line, quiet_prints_nothing) {
  EXPECT_EQ(log_of_a_task(Verbosity::quiet), "");
}

TEST(progress_line, what_was_done_before_is_not_counted_as_the_work_of_now) {
  ::testing::internal::CaptureStderr();
  {
    ProgressLine line("counting", "sheep", Verbosity::normal);
    line.skip(60);
    const Progress progress = line.callback();
    for (std::uint64_t done = 60; done <= 100; ++done) EXPECT_TRUE(progress(done, 100));
    line.finish();
  }
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(log.rfind("counting: 40 sheep in ", 0), 0u) << log;
}

TEST(progress_line, a_note_during_a_stage_has_a_line_of_its_own) {
  ::testing::internal::CaptureStderr();
  {
    Console console(Verbosity::normal);
    const auto stage = console.begin("counting", "sheep");
    EXPECT_TRUE(stage->callback()(50, 100));
    console.note("one is black");
    console.detail("it is called Bert");
    stage->finish();
  }
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(log.rfind("alidade: one is black\ncounting: ", 0), 0u) << log;
}

}  // namespace
}  // namespace alidade::test
