// SPDX-License-Identifier: MIT
#include "database/sqlite/connection.h"

#include "database/sqlite/cloud_table.h"
#include "database/sqlite/functions.h"

namespace alidade::database {
namespace {

/// Waits a moment for the holder of a lock: SQLite's busy handler. Returns 0 to give up.
int wait_for_others(void* is_given_up, int waits_before) {
  constexpr int k_milliseconds = 10, k_most_waits = 1000;
  const auto& stop = *static_cast<const std::function<bool()>*>(is_given_up);
  if (waits_before >= k_most_waits || (stop && stop())) return 0;
  sqlite3_sleep(k_milliseconds);
  return 1;
}

}  // namespace

void Connection::set_up(const std::filesystem::path& file, int flags, const char* vfs) {
  // A file may be called ":memory:".
  const std::filesystem::path path = file.empty() ? ":memory:" : file.is_absolute() ? file : "." / file;
  int result = sqlite3_open_v2(path.c_str(), &database_, flags | SQLITE_OPEN_NOMUTEX, vfs);
  if (result == SQLITE_OK) result = add_functions(database_);
  if (result == SQLITE_OK) result = add_cloud_table(database_, &reads_);
  if (result == SQLITE_OK) result = add_file_tables(database_, &files_);
  if (result != SQLITE_OK)
    throw file_error(file, database_ == nullptr ? sqlite3_errstr(result) : sqlite3_errmsg(database_));
  // Views and triggers that others have put into a file may only query.
  sqlite3_db_config(database_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  // Otherwise a misspelt "name" would be text, which is above every number.
  sqlite3_db_config(database_, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
  sqlite3_busy_handler(database_, wait_for_others, &is_given_up_);
}

Connection::Connection(const std::filesystem::path& file, Mode mode, std::function<bool()> is_given_up)
    : is_given_up_(std::move(is_given_up)) {
  const int flags = mode == Mode::read    ? SQLITE_OPEN_READONLY
                    : mode == Mode::write ? SQLITE_OPEN_READWRITE
                                          : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  try {
    // On network file systems SQLite's locks would conflict with that of create_temporary().
    set_up(file, flags, mode == Mode::create ? "unix-none" : nullptr);
    if (mode == Mode::read) sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    // Opening reads nothing; a file that is not a database fails here.
    Statement(database_, "SELECT count(*) FROM sqlite_schema").step();
  } catch (...) {
    sqlite3_close(database_);
    throw;
  }
}

Connection::Connection(std::span<const std::filesystem::path> clouds, FileTables files)
    : files_(std::move(files)) {
  files_.reads = &reads_;
  std::string names;
  for (const std::filesystem::path& cloud : clouds)
    names += (names.empty() ? "" : ", ") + sql_text(cloud.string());
  try {
    set_up({}, SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY);
    run(database_, "CREATE VIRTUAL TABLE points USING alidade(" + names + ")");
    files_.reading = {};
    files_.warn = {};
  } catch (...) {
    sqlite3_close(database_);
    throw;
  }
}

}  // namespace alidade::database
