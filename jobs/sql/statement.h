// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "database/sqlite/connection.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A value in a row, or for a parameter.
using SqlValue = std::variant<std::monostate, std::int64_t, double, std::string, std::vector<std::byte>>;

/// A value for a parameter of statements. It is bound, and never part of a statement's text.
struct SqlParameter {
  std::string name;  ///< without its sign; empty if it is bound by its position
  SqlValue value;
};

struct SqlParameters {
  std::vector<SqlParameter> values;
  bool are_all_used = true;  ///< whether one that no statement has is an error
};

/// SQL in words or in a file.
struct SqlSource {
  std::optional<std::string> statement{};  ///< "-" is standard input
  std::filesystem::path file{};            ///< if there is no statement; empty or "-" is standard input
};

/// Declares the operand `statement` and --file, with these help texts.
void add_sql_source(const Fields& fields, const std::string& statement_help, const std::string& file_help,
                    SqlSource& source);

/// SQL with its name in messages.
struct SqlText {
  std::string text, name;
};

/// Errors: the file cannot be read; it has a NUL byte.
SqlText read_sql(const SqlSource& source);

/// Read-only statements on a cloud.
struct SqlRequest {
  /// An SQLite file, or cloud files as the table `points`: a file, folder, pattern or catalog.
  std::filesystem::path cloud;
  SqlSource source;
  SqlParameters parameters;
  bool partial = false;  ///< damaged cloud files are read in part: ReadOptions::partial
};

/// Declares all fields. `add_answers` declares those of whoever shows the rows, where the manual has them.
void add_sql_fields(
    const Fields& fields, SqlRequest& request, const std::function<void()>& add_answers = [] {});

struct CheckedSql : SqlRequest {
  bool is_database;             ///< an SQLite file
  std::optional<SqlText> text;  ///< empty: standard input, which is read when the cloud is open
};
using SqlPlan = Plan<CheckedSql>;

/// Checks all that can be checked before a point is read. Errors: no cloud; a server's table; `partial` with
/// a database; those of resolve_clouds() and read_sql().
SqlPlan plan(const SqlRequest& request);

/// How a statement was run.
struct StatementReport {
  database::ScanReads reads{};
  std::uint64_t rows = 0;
  double milliseconds = 0.0;
  std::string rewritten{};  ///< the statement that ran instead (database/sqlite/prepare.h); empty: none
  std::string reason{};     ///< why it, or some condition in it, was not changed; else empty
};

/// Takes the rows of statements, of one after the other.
struct RowSink {
  std::function<void(const std::vector<std::string>& columns)> begin;
  std::function<void(std::span<const SqlValue> values)> row;
  std::function<void(const StatementReport& report)> end;
};

/// Opens the cloud of a plan for reading. `listener` must outlive the connection. Errors: those of
/// database::Connection; Cancelled.
std::unique_ptr<database::Connection> open_cloud(const CheckedSql& request, Listener& listener);

/// Runs all statements of a text; runs none if one of them is invalid. Conditions on dist_ray and dist_plane
/// leave chunks unread. Errors: a statement that is not read-only, has a parameter without value, or is
/// invalid for SQLite; a parameter that no statement has; SQLite's; those of the sink. Cancelled, also while
/// it waits for another process that writes.
void run_statements(const database::Connection& connection, const SqlText& sql,
                    const SqlParameters& parameters, const RowSink& sink, Listener& listener);

/// open_cloud(), then run_statements().
void run(const SqlPlan& plan, const RowSink& sink, Listener& listener);

/// The rows of a statement.
struct StatementResult {
  std::vector<std::string> columns;
  std::vector<std::vector<SqlValue>> values;  ///< of each column
  StatementReport report;
};
using SqlResult = std::vector<StatementResult>;

/// As above; keeps the rows of each statement. Errors: also a request of standard input.
SqlResult run(const SqlPlan& plan, Listener& listener);

}  // namespace alidade::jobs
