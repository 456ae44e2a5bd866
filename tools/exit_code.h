// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// What the program answers to its caller; scripts rely on these numbers.
enum class ExitCode {
  done = 0,          ///< the work is done, or the answer is yes
  no = 1,            ///< the work is done and the answer is no
  failed = 2,        ///< anything wrong: usage, input, no space
  interrupted = 130  ///< Ctrl-C or a termination signal; nothing half-written is left
};

}  // namespace alidade
