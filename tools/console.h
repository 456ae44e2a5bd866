// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "base/progress.h"

namespace alidade {

/// How much the program says on stderr beside errors.
enum class Verbosity { quiet, normal, verbose };

/// Shows how far a task is on stderr: percent, rate and time left. One line that is rewritten on a terminal,
/// a line every tenth of the work (or every half minute) in a log, nothing when quiet. It also stops the task
/// when the user interrupts the program.
///
///   ProgressLine line("reading", "B", verbosity);
///   read_cloud(files, {.progress = line.callback()});
///   line.finish();
class ProgressLine {
 public:
  /// `unit` is what the task counts in, as it stands behind a rate: "points", "camera rays".
  ProgressLine(std::string task, std::string unit, Verbosity verbosity);
  /// Ends a line that was left in the middle.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// To be handed to the task; valid as long as this object.
  Progress callback();

  /// So much was done before: it counts as done, but not for rate and time left.
  void skip(std::uint64_t done) { skipped_ = done; }

  /// Says something on a line of its own in the midst of the task, "alidade: TEXT".
  void interject(const std::string& text);

  /// Says that the task is done, and how fast it was.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  bool report(std::uint64_t done, std::uint64_t total);
  void show(double seconds);

  std::string task_, unit_;
  Verbosity verbosity_;
  bool on_terminal_, line_open_ = false;
  std::uint64_t done_ = 0, total_ = 0, skipped_ = 0;
  int last_tenth_ = 0;
  Clock::time_point start_, last_shown_;
};

/// "1.25 M", "340 k", "12": a count for people to read.
std::string short_count(double count);

/// "0:07", "12:30", "1:02:03".
std::string clock_time(double seconds);

}  // namespace alidade
