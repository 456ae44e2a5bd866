// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

// What the program says to a person, on stderr. A stderr that cannot be written to is no reason to stop.

namespace alidade {

/// The bytes as they are.
void write_to_stderr(std::string_view text);

/// "alidade: error: TEXT" on a line of its own.
void say_error(std::string_view text);

/// "alidade: warning: TEXT".
void say_warning(std::string_view text);

/// "alidade: TEXT": what was assumed or measured on the user's behalf.
void say_note(std::string_view text);

/// Thrown where stdout is a pipe whose reader has gone away: nobody wants the rest, so nothing is said.
struct ReaderGone {};

/// Data for stdout. Errors: stdout cannot take it (no space left, closed); ReaderGone; Cancelled, if the
/// program is interrupted while it waits for the reader.
void write_to_stdout(std::string_view text);

}  // namespace alidade
