// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// What the program answers to its caller; scripts rely on these numbers.
enum class ExitCode {
  done = 0,          ///< the work is done, or the answer is yes
  no = 1,            ///< the work is done and the answer is no
  failed = 2,        ///< anything wrong: usage, input, no space
  sizes_differ = 3,  ///< `compare --idiff-codes` only, where 1 is a warning and 2 beyond a threshold
  unreadable = 4,    ///< the same: anything wrong
  interrupted = 130  ///< Ctrl-C or a termination signal; nothing half-written is left
};

}  // namespace alidade
