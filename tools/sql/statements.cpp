// SPDX-License-Identifier: MIT
#include "tools/sql/run_statements.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/error.h"
#include "database/sqlite/prepare.h"
#include "database/sqlite/sql_tokens.h"
#include "tools/interrupt.h"
#include "tools/message.h"

namespace alidade {
namespace {

[[noreturn]] void refuse_writing(const std::string& file, std::string place, std::string found) {
  throw Error({.file = file,
               .place = std::move(place),
               .problem = "only statements that read are run",
               .expected = "SELECT, WITH, VALUES or EXPLAIN",
               .found = std::move(found)});
}

/// All statements of the text, with values for their parameters.
std::vector<Prepared> prepare_all(sqlite3* database, const std::string& text, const std::string& file,
                                  std::vector<SqlParameter>& parameters) {
  std::vector<Prepared> statements;
  const TokenList tokens(text);
  std::size_t end = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (tokens[i].begin < end || tokens.is_sign(i, ";")) continue;
    const std::size_t begin = tokens[i].begin;
    // Some statements that write do so beside the database, which is open for reading only.
    if (!tokens.is_one_of(i, {"select", "with", "values", "explain"}))
      refuse_writing(file, text_place(text, begin), std::string(tokens.text(i)));
    statements.push_back(prepare(database, text, begin, file));
    sqlite3_stmt* const statement = statements.back().statement.get();
    if (sqlite3_stmt_readonly(statement) == 0)
      refuse_writing(file, text_place(text, begin), "a statement that writes");
    end = begin + statements.back().size;
    bind_parameters(statement, parameters);
  }
  return statements;
}

void refuse_unused(const std::vector<SqlParameter>& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].is_used) continue;
    throw Error({.file = "--param",
                 .problem = parameters[i].name.empty()
                                ? fmt::format("value {} belongs to no parameter of a statement", i + 1)
                                : fmt::format("no statement has a parameter :{}", parameters[i].name)});
  }
}

std::string share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? ""
                  : fmt::format(" ({:.1f} %)", 100.0 * static_cast<double>(part) / static_cast<double>(all));
}

void explain(const Prepared& prepared, const ScanReads& before, const ScanReads& after, std::uint64_t rows,
             double milliseconds) {
  const std::uint64_t scans = after.scans - before.scans, chunks = after.chunks - before.chunks,
                      read = after.chunks_read - before.chunks_read;
  std::string text =
      scans == 0 ? "no cloud read" : fmt::format("{} of {} chunks read{}", read, chunks, share(read, chunks));
  if (scans > 1) text += fmt::format(" in {} scans", scans);
  if (scans > 0) text += fmt::format(", {} points looked at", after.points_read - before.points_read);
  say_note(fmt::format("{}, {} {}, {:.1f} ms", text, rows, rows == 1 ? "row" : "rows", milliseconds));
  if (!prepared.pruned.empty()) say_note("rewritten as: " + prepared.pruned);
  if (!prepared.reason.empty())
    say_note((prepared.pruned.empty() ? "not rewritten: " : "not rewritten further: ") + prepared.reason);
}

void run_one(const Connection& connection, Prepared& prepared, const SqlRun& run) {
  const auto start = std::chrono::steady_clock::now();
  const ScanReads before = connection.reads();
  sqlite3_stmt* const statement = prepared.statement.get();
  std::vector<std::string> columns;
  const int count = sqlite3_column_count(statement);
  columns.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) columns.emplace_back(sqlite3_column_name(statement, i));
  const std::unique_ptr<RowWriter> writer = make_row_writer(run.form);
  writer->begin(columns);
  std::uint64_t rows = 0;
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(statement)) == SQLITE_ROW) {
    writer->row(statement);
    ++rows;
  }
  if (result == SQLITE_INTERRUPT) throw Cancelled();
  if (result != SQLITE_DONE) {
    throw Error(
        {.file = sqlite3_db_filename(connection.get(), "main"), .problem = sqlite3_errmsg(connection.get())});
  }
  writer->end();
  prepared.statement.reset();
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  if (run.explain) explain(prepared, before, connection.reads(), rows, taken.count());
}

}  // namespace

void run_statements(const Connection& connection, const std::string& text, const std::string& file,
                    SqlRun run) {
  constexpr int k_steps = 1000;
  sqlite3_progress_handler(
      connection.get(), k_steps, [](void*) { return interrupted() ? 1 : 0; }, nullptr);
  try {
    std::vector<Prepared> statements = prepare_all(connection.get(), text, file, run.parameters);
    if (run.are_all_used) refuse_unused(run.parameters);
    for (Prepared& prepared : statements) run_one(connection, prepared, run);
  } catch (const Error&) {
    // Such as that the file is locked, once nobody waits any more.
    if (interrupted()) throw Cancelled();
    throw;
  }
}

}  // namespace alidade
