// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "database/sqlite/scan_reads.h"
#include "database/sqlite/sqlite_api.h"

namespace alidade {

/// A connection to an SQLite file with the functions and the table module of Alidade. For one thread at a
/// time.
class Connection {
 public:
  enum class Mode { read, write, create };

  /// While others write, each statement waits for them for up to 10 s, or until `is_given_up` says so.
  /// Errors: the file cannot be opened, or is no database.
  Connection(const std::filesystem::path& file, Mode mode, std::function<bool()> is_given_up = {});
  ~Connection() { sqlite3_close(database_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  sqlite3* get() const { return database_; }
  /// By all scans of clouds that have ended.
  const ScanReads& reads() const { return reads_; }

 private:
  ScanReads reads_;
  std::function<bool()> is_given_up_;
  sqlite3* database_ = nullptr;
};

}  // namespace alidade
