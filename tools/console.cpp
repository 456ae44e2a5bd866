// SPDX-License-Identifier: MIT
#include "tools/console.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "base/shown_text.h"

namespace alidade::tools {
namespace {

// The only state a signal handler may touch.
volatile std::sig_atomic_t signal_came = 0;

std::atomic<bool> are_remote_notes_silent = false;  // -q, for what has no Console

void note_signal(int signal) {
  signal_came = signal;
}

// Back to the first column, and the rest of the terminal's line cleared.
const std::string k_line_start = "\r\033[K";

void say(std::string_view kind, std::string_view text) {
  std::string line = "alidade: ";
  line.append(kind).append(line_text(text)).append("\n");
  write_to_stderr(line);
}

}  // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = note_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
  // A file beyond the limit of its size is a failed write, which is reported and leaves nothing behind.
  struct sigaction ignored = {};
  ignored.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &ignored, nullptr);
  // So is writing to a pipe whose reader has closed it.
  sigaction(SIGPIPE, &ignored, nullptr);
}

void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  std::raise(SIGPIPE);
  // Reached only where the caller of the program has blocked the signal.
  std::_Exit(static_cast<int>(ExitCode::failed));
}

bool interrupted() {
  return signal_came != 0;
}

bool forget_ctrl_c() {
  if (signal_came != 0 && signal_came != SIGINT) return false;
  signal_came = 0;
  catch_interrupts();
  return true;
}

void write_to_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void say_error(std::string_view text) {
  say("error: ", text);
}
void say_warning(std::string_view text) {
  say("warning: ", text);
}
void say_note(std::string_view text) {
  say("", text);
}

void say_remote_note(const std::string& text) {
  if (are_remote_notes_silent) return;
  if (::isatty(STDERR_FILENO) == 1) write_to_stderr(k_line_start);
  say_note(text);
}

void silence_remote_notes() {
  are_remote_notes_silent = true;
}

bool confirm(const std::string& question) {
  if (::isatty(STDIN_FILENO) != 1 || ::isatty(STDERR_FILENO) != 1) return false;
  write_to_stderr(k_line_start + "alidade: " + line_text(question) + " [y/N] ");
  // Signals may come to another thread, and would not end a read().
  constexpr int k_between_looks = 100;  // milliseconds
  ::pollfd line{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  while (!interrupted() && ::poll(&line, 1, k_between_looks) <= 0) {
  }
  if (interrupted()) throw Cancelled();
  std::string answer(80, '\0');  // a terminal gives a line at once
  const ::ssize_t count = ::read(STDIN_FILENO, answer.data(), answer.size());
  answer.resize(static_cast<std::size_t>(std::max<::ssize_t>(count, 0)));
  return answer == "y\n" || answer == "Y\n" || answer == "yes\n";
}

void say_warnings(Verbosity verbosity, const std::vector<std::string>& texts) {
  if (verbosity == Verbosity::quiet) return;
  for (const std::string& text : texts) say_warning(text);
}

void say_note(Verbosity verbosity, std::string_view text) {
  if (verbosity != Verbosity::quiet) say_note(text);
}

void write_to_stdout(std::string_view text) {
  // Not by stdio, which continues to wait for the reader after a signal.
  while (!text.empty()) {
    if (interrupted()) throw Cancelled();
    const ::ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
    if (count >= 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EPIPE) {
      throw ReaderGone();
    } else if (errno != EINTR) {
      throw system_error("standard output", "cannot write");
    }
  }
}

ProgressLine::ProgressLine(std::string task, std::string unit, Verbosity verbosity,
                           std::shared_ptr<const ProgressLine*> on_line)
    : task_(std::move(task)),
      unit_(std::move(unit)),
      verbosity_(verbosity),
      on_terminal_(isatty(STDERR_FILENO) == 1),
      on_line_(std::move(on_line)),
      start_(Clock::now()),
      last_shown_(start_) {}

ProgressLine::~ProgressLine() {
  if (*on_line_ != this) return;
  write_to_stderr("\n");
  *on_line_ = nullptr;
}

Progress ProgressLine::callback() {
  return [this](std::uint64_t done, std::uint64_t total) { return report(done, total); };
}

bool ProgressLine::report(std::uint64_t done, std::uint64_t total) {
  done_ = done;
  total_ = total;
  if (interrupted()) return false;
  if (verbosity_ == Verbosity::quiet || total == 0) return true;
  const Clock::time_point now = Clock::now();
  const double since_shown = std::chrono::duration<double>(now - last_shown_).count();
  const int tenth = static_cast<int>(10.0 * static_cast<double>(done) / static_cast<double>(total));
  const bool due =
      on_terminal_ ? since_shown >= 0.1 : (tenth > last_tenth_ && since_shown >= 2.0) || since_shown >= 30.0;
  if (!due) return true;
  last_shown_ = now;
  last_tenth_ = tenth;
  show(std::chrono::duration<double>(now - start_).count());
  return true;
}

void ProgressLine::show(double seconds) {
  const double share = static_cast<double>(done_) / static_cast<double>(total_);
  std::string text = fmt::format("{}: {:3.0f} %", task_, 100.0 * share);
  if (done_ > skipped_ && seconds > 0.0) {
    const double rate = static_cast<double>(done_ - skipped_) / seconds;
    text += fmt::format(", {}/s", quantity(rate, unit_));
    text +=
        fmt::format(", {} left", clock_time(static_cast<double>(total_ - std::min(done_, total_)) / rate));
  }
  if (on_terminal_) {
    write_to_stderr(k_line_start + text);
    *on_line_ = this;
  } else {
    write_to_stderr(text + "\n");
  }
}

void ProgressLine::finish() {
  if (verbosity_ == Verbosity::quiet) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  const auto count = static_cast<double>(total_ - std::min(skipped_, total_));
  std::string text = fmt::format("{}: {} in {:.1f} s", task_, quantity(count, unit_), seconds);
  if (seconds > 0.5) text += fmt::format(" ({}/s)", quantity(count / seconds, unit_));
  write_to_stderr((on_terminal_ ? k_line_start : "") + text + "\n");
  *on_line_ = nullptr;
}

void Console::begin_line() {
  if (*on_line_ != nullptr) write_to_stderr(k_line_start);
  *on_line_ = nullptr;
}

void Console::note(std::string_view text) {
  if (!is_listening()) return;
  begin_line();
  say_note(text);
}

void Console::warn(std::string_view text) {
  if (is_listening()) warn_always(text);
}

void Console::warn_always(std::string_view text) {
  begin_line();
  say_warning(text);
}

void Console::detail(std::string_view text) {
  if (verbosity_ == Verbosity::verbose) note(text);
}

std::unique_ptr<jobs::Listener::Stage> Console::begin(std::string task, std::string unit) {
  return std::make_unique<ProgressLine>(std::move(task), std::move(unit), verbosity_, on_line_);
}

}  // namespace alidade::tools
