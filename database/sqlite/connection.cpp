// SPDX-License-Identifier: MIT
#include "database/sqlite/connection.h"

#include "database/sqlite/cloud_table.h"
#include "database/sqlite/functions.h"
#include "database/sqlite/statement.h"

namespace alidade {

Connection::Connection(const std::filesystem::path& file, Mode mode) {
  const int flags = mode == Mode::read    ? SQLITE_OPEN_READONLY
                    : mode == Mode::write ? SQLITE_OPEN_READWRITE
                                          : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  try {
    // Names such as ":memory:" are those of files here.
    const std::filesystem::path path = file.is_absolute() ? file : "." / file;
    int result = sqlite3_open_v2(path.c_str(), &database_, flags | SQLITE_OPEN_NOMUTEX, nullptr);
    if (result == SQLITE_OK) result = add_functions(database_);
    if (result == SQLITE_OK) result = add_cloud_table(database_, &reads_);
    if (result != SQLITE_OK) {
      throw Error({.file = file.string(),
                   .problem = database_ == nullptr ? sqlite3_errstr(result) : sqlite3_errmsg(database_)});
    }
    // What others put into a file, such as views and triggers, may do nothing but ask.
    sqlite3_db_config(database_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    if (mode == Mode::read) sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    // Whoever reads or writes in the meantime is waited for.
    constexpr int k_milliseconds = 10'000;
    sqlite3_busy_timeout(database_, k_milliseconds);
    // Opening looks at nothing; a file that is no database shows here.
    Statement(database_, "SELECT count(*) FROM sqlite_schema").step();
  } catch (...) {
    sqlite3_close(database_);
    throw;
  }
}

}  // namespace alidade
