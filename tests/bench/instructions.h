// SPDX-License-Identifier: MIT
#pragma once

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <stdexcept>

namespace alidade::bench {

/// How many instructions a copy of this process executes until it has done `work` and ended, counted by
/// single steps, also on machines without hardware counters. Takes some microseconds for each. Repeated string
/// instructions (long copies) count once for each repetition. `work` must need no other thread. Throws where
/// processes may not be traced.
template <class Work>
std::uint64_t instructions_until_end(const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  std::uint64_t count = 0;
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) == child && WIFSTOPPED(status)) {
    if (WSTOPSIG(status) != SIGTRAP && WSTOPSIG(status) != SIGSTOP) {
      kill(child, SIGKILL);
      continue;
    }
    if (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) != 0) break;
    ++count;
  }
  if (child <= 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("instructions cannot be counted: this system does not let processes be traced");
  return count;
}

/// Of the work alone, done before: what is done at the first time only is not counted.
template <class Work>
std::uint64_t count_instructions(const Work& work) {
  work();
  return instructions_until_end(work) - instructions_until_end([] {});
}

}  // namespace alidade::bench
