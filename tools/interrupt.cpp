// SPDX-License-Identifier: MIT
#include "tools/interrupt.h"

#include <csignal>
#include <cstdlib>

#include "tools/exit_code.h"

namespace alidade {
namespace {

// The only state a signal handler may touch; nothing else in the program is global.
volatile std::sig_atomic_t signal_came = 0;

void note_signal(int signal) {
  signal_came = signal;
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
  // A file beyond the limit of its size is a failed write, which is told and leaves nothing behind.
  struct sigaction ignored = {};
  ignored.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &ignored, nullptr);
  // So is writing to a reader that has gone away.
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

}  // namespace alidade
