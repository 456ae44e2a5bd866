// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/run_program.h"

namespace alidade::test {

/// A person at a terminal who has started the program.
class Terminal {
 public:
  /// Starts `alidade WORDS...` in `folder`.
  Terminal(const std::filesystem::path& folder, const Words& words) {
    const std::string program = program_file(), state = folder / "state";
    std::vector<char*> arguments = {const_cast<char*>(program.c_str())};
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    process_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (process_ != 0) return;
    ::setenv("XDG_STATE_HOME", state.c_str(), 1);
    ::setenv("TERM", "xterm", 1);
    if (::chdir(folder.c_str()) != 0) ::_exit(125);
    ::execv(program.c_str(), arguments.data());
    ::_exit(126);
  }
  ~Terminal() {
    if (terminal_ >= 0) ::close(terminal_);
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Types keys and waits until `expected` is shown after them; all that was shown, of the failure too.
  ::testing::AssertionResult shows(const std::string& keys, const std::string& expected) {
    shown_.clear();
    if (::write(terminal_, keys.data(), keys.size()) < 0)
      return ::testing::AssertionFailure() << "cannot type";
    while (shown_.find(expected) == std::string::npos) {
      if (!read_more()) return ::testing::AssertionFailure() << "shown: " << shown_;
    }
    return ::testing::AssertionSuccess();
  }

  /// The same, once the program edits lines: until then the terminal's own rules for keys hold.
  ::testing::AssertionResult edits(const std::string& keys, const std::string& expected) {
    termios rules = {};
    for (int i = 0;
         i < k_longest_wait && ::tcgetattr(terminal_, &rules) == 0 && (rules.c_lflag & ICANON) != 0; ++i)
      ::poll(nullptr, 0, 1);
    return shows(keys, expected);
  }

  /// The program's exit code, once it has ended.
  int exit_code() {
    while (read_more()) {
    }
    // Ends it if it has not ended, with another code.
    ::close(std::exchange(terminal_, -1));
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  static constexpr int k_longest_wait = 30'000;  ///< milliseconds

  bool read_more() {
    pollfd waiting{.fd = terminal_, .events = POLLIN, .revents = 0};
    char part[4096];
    if (::poll(&waiting, 1, k_longest_wait) != 1) return false;
    const ::ssize_t count = ::read(terminal_, part, sizeof part);
    if (count > 0) shown_.append(part, static_cast<std::size_t>(count));
    return count > 0;
  }

  int terminal_ = -1;
  pid_t process_ = -1;
  std::string shown_;
};

}  // namespace alidade::test
