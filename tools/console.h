// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "jobs/listener.h"

namespace alidade::tools {

/// Exit codes of the program; scripts rely on these numbers.
enum class ExitCode {
  done = 0,          ///< the work is done, or the answer is yes
  no = 1,            ///< the work is done and the answer is no
  failed = 2,        ///< anything wrong: usage, input, no space
  sizes_differ = 3,  ///< `compare --idiff-codes` only, where 1 is a warning and 2 beyond a threshold
  unreadable = 4,    ///< `compare --idiff-codes` only: anything wrong
  interrupted = 130  ///< Ctrl-C or a termination signal; nothing half-written is left
};

/// Makes Ctrl-C, a termination signal and the end of the terminal set a flag only, so that a running task can
/// stop at its next progress report and remove what it has begun. A second signal ends the program at once.
/// Writing into a pipe without a reader becomes a failed write instead of a signal.
void catch_interrupts();

/// Ends the program as SIGPIPE would have, which a shell expects in the middle of a pipeline.
[[noreturn]] void end_by_broken_pipe();

/// Whether one of these signals has been received.
bool interrupted();

/// Clears the flag of Ctrl-C, so that a prompt can continue. False if another signal has been received.
bool forget_ctrl_c();

// Messages to people, on stderr. Failure to write them is ignored. Each text becomes one line, whatever names
// from files it holds (line_text(), base/shown_text.h).

/// The bytes as they are.
void write_to_stderr(std::string_view text);

/// "alidade: error: TEXT" on a line of its own.
void say_error(std::string_view text);

/// "alidade: warning: TEXT".
void say_warning(std::string_view text);

/// "alidade: TEXT": an assumption or a measurement on the user's behalf.
void say_note(std::string_view text);

/// A note of functions without a Console, which open remote files, also while a line of progress is shown:
/// say_note(), unless silence_remote_notes() was called.
void say_remote_note(const std::string& text);
void silence_remote_notes();

/// Asks on the terminal: "alidade: QUESTION [y/N] ". False for any other answer than yes, and if input or
/// messages are not those of a terminal. Errors: Cancelled, if the program is interrupted meanwhile.
bool confirm(const std::string& question);

/// How much the program prints on stderr beside errors.
enum class Verbosity { quiet, normal, verbose };

// Warnings and notes as above, unless `verbosity` is quiet.
void say_warnings(Verbosity verbosity, const std::vector<std::string>& texts);
void say_note(Verbosity verbosity, std::string_view text);

/// Thrown where stdout is a pipe whose reader has closed it: the program ends without a message.
struct ReaderGone {};

/// Data for stdout. Errors: stdout cannot take it (no space left, closed); ReaderGone; Cancelled, if the
/// program is interrupted while it waits for the reader.
void write_to_stdout(std::string_view text);

/// Shows how far a task is on stderr: percent, rate and time left. One line that is rewritten on a terminal,
/// a line every tenth of the work (or every half minute) in a log, nothing when quiet. It also stops the task
/// when the user interrupts the program.
///
///   ProgressLine line("reading", "B", verbosity);
///   read_cloud(files, {.progress = line.callback()});
///   line.finish();
class ProgressLine : public jobs::Listener::Stage {
 public:
  /// `unit`: of the task's count, as written behind a rate: "points", "camera rays". `on_line`: who has left
  /// the terminal in the middle of a line, for others that print there; null: nobody.
  ProgressLine(std::string task, std::string unit, Verbosity verbosity,
               std::shared_ptr<const ProgressLine*> on_line = std::make_shared<const ProgressLine*>(nullptr));
  /// Ends a line that was left in the middle.
  ~ProgressLine() override;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// To be handed to the task; valid as long as this object.
  Progress callback() override;

  /// Counts so much, done by an earlier run, as done, but not for rate and time left.
  void skip(std::uint64_t done) override { skipped_ = done; }

  /// Prints that the task is done, and its rate.
  void finish() override;

 private:
  using Clock = std::chrono::steady_clock;

  bool report(std::uint64_t done, std::uint64_t total);
  void show(double seconds);

  std::string task_, unit_;
  Verbosity verbosity_;
  bool on_terminal_;
  std::shared_ptr<const ProgressLine*> on_line_;
  std::uint64_t done_ = 0, total_ = 0, skipped_ = 0;
  int last_tenth_ = 0;
  Clock::time_point start_, last_shown_;
};

/// Returns what work(progress) returns; shows its progress as a ProgressLine.
template <class Work>
auto with_progress(std::string task, std::string unit, Verbosity verbosity, const Work& work) {
  ProgressLine line(std::move(task), std::move(unit), verbosity);
  if constexpr (std::is_void_v<std::invoke_result_t<Work, Progress>>) {
    work(line.callback());
    line.finish();
  } else {
    auto result = work(line.callback());
    line.finish();
    return result;
  }
}

/// Who runs a command from a terminal or a script: prints what jobs say, on lines of their own, also while a
/// stage is under way.
class Console : public jobs::Listener {
 public:
  explicit Console(Verbosity verbosity) : verbosity_(verbosity) {}

  void note(std::string_view text) override;
  void warn(std::string_view text) override;
  void warn_always(std::string_view text) override;
  void detail(std::string_view text) override;
  bool is_listening() const override { return verbosity_ != Verbosity::quiet; }
  std::unique_ptr<Stage> begin(std::string task, std::string unit) override;
  bool stops() const override { return interrupted(); }

 private:
  /// Clears a line of progress, which is printed again.
  void begin_line();

  Verbosity verbosity_;
  std::shared_ptr<const ProgressLine*> on_line_ = std::make_shared<const ProgressLine*>(nullptr);
};

}  // namespace alidade::tools
