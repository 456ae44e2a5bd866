// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "database/sqlite/functions.h"

namespace alidade::database {

/// Replaces a message for SQLite, which frees it.
inline void keep_message(char** kept, const char* message) {
  sqlite3_free(*kept);
  *kept = sqlite3_mprintf("%s", message);
}

/// Runs a callback of a table (guarded()), which keeps the message of an exception.
template <class Work>
int table_guarded(sqlite3_vtab* table, const Work& work) {
  return guarded(work, [&](const char* message) { keep_message(&table->zErrMsg, message); });
}

/// The table, and the cursor, of SQLite's part of it, which is its first member.
template <class Table>
Table& table_of(sqlite3_vtab* base) {
  return *reinterpret_cast<Table*>(base);
}
template <class Cursor>
Cursor& cursor_of(sqlite3_vtab_cursor* base) {
  return *reinterpret_cast<Cursor*>(base);
}

/// A module of tables that are only read, without xConnect and xCreate, which make a Table by new. Table has
///   sqlite3_vtab base{};  // SQLite's part, which must be first
///   int best_index(sqlite3_index_info& info) const;  // returns SQLite's code
/// and Cursor has
///   sqlite3_vtab_cursor base{};  // SQLite's part, which must be first
///   explicit Cursor(const Table& table);
///   void filter(int order, const char* plan, std::span<sqlite3_value* const> values);
///   void next();
///   bool at_end() const noexcept;
///   void column(sqlite3_context* context, int number);
///   sqlite3_int64 row_id() const noexcept;  // unless the table is WITHOUT ROWID
/// Exceptions become SQLite's errors.
template <class Table, class Cursor>
sqlite3_module reading_module() {
  sqlite3_module module{};
  module.xBestIndex = [](sqlite3_vtab* base, sqlite3_index_info* info) {
    return table_guarded(base, [&] { return table_of<Table>(base).best_index(*info); });
  };
  module.xDisconnect = [](sqlite3_vtab* base) {
    delete &table_of<Table>(base);
    return SQLITE_OK;
  };
  module.xOpen = [](sqlite3_vtab* base, sqlite3_vtab_cursor** made) {
    return table_guarded(base,
                         [&] { *made = &std::make_unique<Cursor>(table_of<Table>(base)).release()->base; });
  };
  module.xClose = [](sqlite3_vtab_cursor* base) {
    delete &cursor_of<Cursor>(base);
    return SQLITE_OK;
  };
  module.xFilter = [](sqlite3_vtab_cursor* base, int order, const char* plan, int count,
                      sqlite3_value** values) {
    return table_guarded(base->pVtab, [&] {
      cursor_of<Cursor>(base).filter(order, plan == nullptr ? "" : plan,
                                     std::span(values, static_cast<std::size_t>(count)));
    });
  };
  module.xNext = [](sqlite3_vtab_cursor* base) {
    return table_guarded(base->pVtab, [&] { cursor_of<Cursor>(base).next(); });
  };
  module.xEof = [](sqlite3_vtab_cursor* base) { return cursor_of<Cursor>(base).at_end() ? 1 : 0; };
  module.xColumn = [](sqlite3_vtab_cursor* base, sqlite3_context* context, int number) {
    return table_guarded(base->pVtab, [&] { cursor_of<Cursor>(base).column(context, number); });
  };
  if constexpr (requires(const Cursor& cursor) { cursor.row_id(); }) {
    module.xRowid = [](sqlite3_vtab_cursor* base, sqlite3_int64* id) {
      *id = cursor_of<Cursor>(base).row_id();
      return SQLITE_OK;
    };
  }
  return module;
}

}  // namespace alidade::database
