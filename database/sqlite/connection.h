// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "database/file_cloud.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/sqlite_api.h"

namespace alidade::database {

/// The file of one of a connection's databases, for messages.
inline std::string file_of(sqlite3* database, const std::string& schema = "main") {
  const char* const file = sqlite3_db_filename(database, schema.c_str());
  return file == nullptr ? "" : file;
}

/// An Error with a result code of SQLite.
class SqliteError : public Error {
 public:
  SqliteError(int code, Parts parts) : Error(std::move(parts)), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

/// Throws the Error about invalid values in the tables of a cloud.
[[noreturn]] inline void reject_stored(Error::Parts parts) {
  throw SqliteError(SQLITE_CORRUPT_VTAB, std::move(parts));
}

/// The tables that a statement may read.
enum class Readable {
  everything,
  /// No virtual tables and no views. Otherwise, in a crafted file, reading the tables of a cloud could read
  /// the cloud again.
  plain_tables,
};

/// A prepared statement of SQLite. As in SQLite, parameters are counted from 1, columns from 0.
/// Errors of all members: SQLite's message, with the name of the database file.
class Statement {
 public:
  /// `schema`: the database that it is about, for messages.
  Statement(sqlite3* database, const std::string& sql, Readable readable = Readable::everything,
            std::string schema = "main")
      : database_(database), schema_(std::move(schema)) {
    const unsigned flags = readable == Readable::plain_tables ? SQLITE_PREPARE_NO_VTAB : 0;
    const int result =
        sqlite3_prepare_v3(database, sql.c_str(), static_cast<int>(sql.size()), flags, &statement_, nullptr);
    if (result != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int index, std::int64_t value) {
    return check(sqlite3_bind_int64(statement_, index, value));
  }
  Statement& bind(int index, double value) { return check(sqlite3_bind_double(statement_, index, value)); }
  Statement& bind(int index, const std::string& text) {
    return check(
        sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  }

  /// The bytes must remain valid until the next step(). A null pointer is NULL.
  Statement& bind(int index, std::span<const std::byte> bytes) {
    return check(sqlite3_bind_blob64(statement_, index, bytes.data(), bytes.size(), SQLITE_STATIC));
  }

  /// Whether there is another row.
  bool step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) fail();
    return result == SQLITE_ROW;
  }

  /// Runs a statement without rows, after which it can be bound and run again.
  void run() {
    step();
    reset();
  }

  /// Binds all parameters, then run().
  template <class... Values>
  void run_with(const Values&... values) {
    int index = 0;
    (bind(++index, values), ...);
    run();
  }
  void reset() { sqlite3_reset(statement_); }

  /// SQLITE_INTEGER, SQLITE_FLOAT, SQLITE_TEXT, SQLITE_BLOB or SQLITE_NULL.
  int type(int column) const { return sqlite3_column_type(statement_, column); }
  bool is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::int64_t whole(int column) const { return sqlite3_column_int64(statement_, column); }
  double number(int column) const { return sqlite3_column_double(statement_, column); }
  std::string text(int column) const {
    const unsigned char* const start = sqlite3_column_text(statement_, column);
    return start == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(start));
  }

  /// Valid until the next step().
  std::span<const std::byte> bytes(int column) const {
    const void* const start = sqlite3_column_blob(statement_, column);
    return {static_cast<const std::byte*>(start),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  Statement& check(int result) {
    if (result != SQLITE_OK) fail();
    return *this;
  }
  [[noreturn]] void fail() const {
    const std::string file = file_of(database_, schema_), message = sqlite3_errmsg(database_);
    // Messages of clouds begin with the name of the file.
    throw SqliteError(sqlite3_errcode(database_),
                      {.file = message.starts_with(file + ":") ? "" : file, .problem = message});
  }

  sqlite3* database_;
  std::string schema_;
  sqlite3_stmt* statement_ = nullptr;
};

/// Runs SQL without parameters and rows.
inline void run(sqlite3* database, const std::string& sql) {
  Statement(database, sql).run();
}

/// A connection to an SQLite file, or to cloud files, with the functions and table modules of Alidade.
/// For one thread at a time.
class Connection {
 public:
  enum class Mode { read, write, create };

  /// While others write, each statement waits for them for up to 10 s, or until `is_given_up` returns true.
  /// A file that is created has no other readers and is not locked. Errors: the file cannot be opened, or is
  /// not a database.
  Connection(const std::filesystem::path& file, Mode mode, std::function<bool()> is_given_up = {});
  /// A database in memory with the table `points` over cloud files. Of `files`, `reading` and `warn` are used
  /// only until it is made; `reads` is not used. Errors: those of FileCloud (database/file_cloud.h).
  Connection(std::span<const std::filesystem::path> clouds, FileTables files);
  ~Connection() { sqlite3_close(database_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  sqlite3* get() const { return database_; }
  /// Of all scans of clouds that have ended.
  const ScanReads& reads() const { return reads_; }

 private:
  /// An empty `file` is a database in memory.
  void set_up(const std::filesystem::path& file, int flags, const char* vfs = nullptr);

  ScanReads reads_;
  FileTables files_{.reads = &reads_};
  std::function<bool()> is_given_up_;
  sqlite3* database_ = nullptr;
};

}  // namespace alidade::database
