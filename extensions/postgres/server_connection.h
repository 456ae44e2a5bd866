// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "extensions/postgres/server_name.h"

struct pg_conn;
struct pg_result;

namespace alidade::database {

/// Called some times per second while a server works; what it throws ends the wait.
using ServerWait = std::function<void()>;

/// The rows of a statement's result, as text.
class ServerRows {
 public:
  explicit ServerRows(pg_result* result) : result_(result) {}
  ~ServerRows();
  ServerRows(ServerRows&& other) noexcept : result_(other.result_) { other.result_ = nullptr; }
  ServerRows& operator=(ServerRows&&) = delete;

  std::size_t size() const;
  bool is_null(std::size_t row, int column) const;
  /// A value as text; empty for NULL.
  std::string text(std::size_t row, int column) const;
  /// A value as a number; 0 for NULL.
  double number(std::size_t row, int column) const;
  std::int64_t whole(std::size_t row, int column) const;

 private:
  pg_result* result_;
};

/// A session on a server. If it ends inside a transaction, that is rolled back; a running statement is
/// cancelled. Not thread safe. Errors of all functions: the server's message, with the name of the table; the
/// connection is lost.
class ServerConnection {
 public:
  /// Waits 10 s for the server, unless the name has another time. Errors: no server, wrong database or user.
  explicit ServerConnection(const ServerName& name);
  ~ServerConnection();
  ServerConnection(const ServerConnection&) = delete;
  ServerConnection& operator=(const ServerConnection&) = delete;

  /// Runs one statement with these texts for $1, $2, ...
  ServerRows run(const std::string& sql, std::span<const std::string> values = {},
                 const ServerWait& wait = {});

  /// Runs COPY ... TO STDOUT; calls `take` with its bytes, piece by piece.
  void copy_out(const std::string& sql, const std::function<void(std::span<const std::byte>)>& take,
                const ServerWait& wait = {});

  /// Runs COPY ... FROM STDIN in three steps.
  void begin_copy_in(const std::string& sql);
  void put(std::span<const std::byte> bytes, const ServerWait& wait = {});
  void end_copy_in(const ServerWait& wait = {});

  /// The name of the table, for messages.
  const std::string& name() const { return name_; }
  /// Throws an Error with the name of the table.
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {},
                         std::string location = {}) const;

 private:
  void send(const std::string& sql, std::span<const std::string> values);
  void wait_for_socket(bool to_write, const ServerWait& wait);
  void flush(const ServerWait& wait);
  void wait_while_busy(const ServerWait& wait);
  ServerRows result(int wanted, const ServerWait& wait);
  void finish_statement(const ServerWait& wait);
  /// Throws the Error about a problem, with libpq's message if it has one.
  [[noreturn]] void fail_with_reason(const char* problem) const;
  [[noreturn]] void fail_as_lost() const { fail_with_reason("lost connection to the server"); }

  std::string name_;
  pg_conn* connection_ = nullptr;
};

}  // namespace alidade::database
