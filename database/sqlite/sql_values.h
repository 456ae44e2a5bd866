// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <string>

#include "database/sqlite/statement.h"

// What SQLite hands to functions and tables of the module, and what they answer.

namespace alidade {

/// Runs `work` for a callback of SQLite, through which no exception may pass; `fail` gets the message.
template <class Work, class Fail>
int guarded(const Work& work, const Fail& fail) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return SQLITE_NOMEM;
  } catch (const SqliteError& error) {
    fail(error.what());
    return error.code();
  } catch (const std::exception& error) {
    fail(error.what());
    return SQLITE_ERROR;
  }
}

/// The numbers of some arguments; empty if one of them is NULL. Errors: one is neither number nor NULL, named
/// with `function` and counted from 1.
template <std::size_t count>
std::optional<std::array<double, count>> numbers(std::span<sqlite3_value* const> values,
                                                 const char* function);

extern template std::optional<std::array<double, 6>> numbers<6>(std::span<sqlite3_value* const>, const char*);
extern template std::optional<std::array<double, 8>> numbers<8>(std::span<sqlite3_value* const>, const char*);
extern template std::optional<std::array<double, 9>> numbers<9>(std::span<sqlite3_value* const>, const char*);

}  // namespace alidade
