// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "database/postgres/postgres_api.h"

extern "C" {
#include <lib/stringinfo.h>
}

// Numbers as the text and the bytes of a value of SQL. Errors are PostgreSQL's.

namespace alidade {

/// Reads "(1,2,3)", where spaces may stand, up to its end. `text` is what stands between `all` and its end;
/// error messages name the type and all of the text.
void read_numbers(const char* text, const char* all, const char* type, std::span<double> numbers);

/// Writes them so, as exactly as the setting extra_float_digits asks for, which by default is exactly.
void append_numbers(StringInfo text, std::span<const double> numbers);

/// Reads or writes the numbers of a message of the binary protocol.
void receive_numbers(StringInfo message, std::span<double> numbers);
void send_numbers(StringInfo message, std::span<const double> numbers);

/// Ends with the error that a text is none of the type.
[[noreturn]] void refuse_text(const char* all, const char* type);

}  // namespace alidade
