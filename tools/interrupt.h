// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// From now on Ctrl-C, a termination signal and the end of the terminal only leave a note, so that a running
/// task can stop at its next progress report and remove what it has begun. A second signal ends the program
/// at once.
void catch_interrupts();

/// Whether such a signal has come.
bool interrupted();

}  // namespace alidade
