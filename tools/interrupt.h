// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// From now on Ctrl-C, a termination signal and the end of the terminal only leave a note, so that a running
/// task can stop at its next progress report and remove what it has begun. A second signal ends the program
/// at once. Writing into a pipe that nobody reads is from now on a failed write and no signal.
void catch_interrupts();

/// Ends the program as that signal would have, which is what a shell expects of the middle of a pipeline.
[[noreturn]] void end_by_broken_pipe();

/// Whether such a signal has come.
bool interrupted();

/// Lets a prompt go on after Ctrl-C: from now on it has not come. False if another signal has.
bool forget_ctrl_c();

}  // namespace alidade
