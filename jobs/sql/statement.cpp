// SPDX-License-Identifier: MIT
#include "jobs/sql/statement.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/prepare.h"
#include "database/sqlite/stored_cloud.h"
#include "jobs/cloud_fields.h"
#include "jobs/load_cloud.h"
#include "jobs/remote_files.h"

namespace alidade::jobs {
namespace {

bool is_letter(char character) {
  return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') || character == '_';
}

bool is_parameter_name(std::string_view text) {
  return !text.empty() && is_letter(text.front()) && std::ranges::all_of(text, [](char character) {
    return is_letter(character) || (character >= '0' && character <= '9');
  });
}

/// A number as in SQL: blanks around it and a plus are allowed.
std::optional<SqlValue> sql_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  // Other words for numbers, such as inf and nan, are text in SQL.
  const std::string_view unsigned_text = text.substr(text.starts_with('-') ? 1 : 0);
  if (unsigned_text.find_first_of(".0123456789") != 0) return std::nullopt;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  std::int64_t integer = 0;
  if (const auto [stop, error] = std::from_chars(begin, end, integer); stop == end && error == std::errc())
    return integer;
  double real = 0;
  const auto [stop, error] = std::from_chars(begin, end, real);
  if (stop != end) return std::nullopt;
  // In SQL, numbers too large for a double are infinite, and numbers too small are zero.
  return error == std::errc() ? real : std::strtod(std::string(text).c_str(), nullptr);
}

/// NULL, a number, 'text' with quotes in it written twice, or text without quotes. Errors: text without
/// quotes that begins like a number, with a digit, dot or sign.
SqlValue sql_value(std::string_view text) {
  if (text == "NULL" || text == "null") return {};
  constexpr const char* k_blanks = " \t\n\v\f\r";
  const std::size_t first = text.find_first_not_of(k_blanks);
  if (first != std::string_view::npos) {
    const std::string_view word = text.substr(first, text.find_last_not_of(k_blanks) + 1 - first);
    if (std::optional<SqlValue> value = sql_number(word)) return std::move(*value);
    // As text it would compare greater than every number.
    if (std::string_view("0123456789.+-").find(word.front()) != std::string_view::npos)
      throw file_error("--param", "invalid number", "a number, or quoted text: \"'TEXT'\"",
                       std::string(text));
  }
  if (text.size() < 2 || text.front() != '\'' || text.back() != '\'') return std::string(text);
  return database::unquoted(text);
}

/// "1.5", "name=value".
SqlParameter parse_sql_parameter(const std::string& text) {
  const std::size_t equals = text.find('=');
  const bool has_name = equals != std::string::npos && is_parameter_name({text.data(), equals});
  return has_name ? SqlParameter{text.substr(0, equals), sql_value(std::string_view(text).substr(equals + 1))}
                  : SqlParameter{"", sql_value(text)};
}

bool is_standard_input(const SqlSource& source) {
  return source.statement ? *source.statement == "-" : source.file.empty() || source.file == "-";
}

/// By extension, so that missing and damaged databases count too, and by content.
bool names_database(const std::filesystem::path& name) {
  if (has_extension(name, {".db", ".db3", ".sqlite", ".sqlite3", ".gpkg"})) return true;
  return resolve_clouds({&name, 1}, cloud_formats()).only(database::k_sqlite_format) != nullptr;
}

void bind(sqlite3_stmt* statement, int index, const SqlValue& value) {
  int result = SQLITE_OK;
  if (const auto* const integer = std::get_if<std::int64_t>(&value)) {
    result = sqlite3_bind_int64(statement, index, *integer);
  } else if (const auto* const real = std::get_if<double>(&value)) {
    result = sqlite3_bind_double(statement, index, *real);
  } else if (const auto* const text = std::get_if<std::string>(&value)) {
    result = sqlite3_bind_text64(statement, index, text->data(), text->size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  } else if (const auto* const bytes = std::get_if<std::vector<std::byte>>(&value)) {
    // A null pointer would be NULL.
    result = bytes->empty()
                 ? sqlite3_bind_zeroblob(statement, index, 0)
                 : sqlite3_bind_blob64(statement, index, bytes->data(), bytes->size(), SQLITE_TRANSIENT);
  }
  if (result != SQLITE_OK) throw file_error("--param", sqlite3_errstr(result));
}

/// Gives all parameters of a statement their values: ? those without a name in their order, ?2 the second one
/// of these, :name, @name and $name those of that name. Errors: one has no value.
void bind_all(sqlite3_stmt* statement, const std::vector<SqlParameter>& values, std::vector<bool>& is_used) {
  int named = 0;
  for (int index = 1; index <= sqlite3_bind_parameter_count(statement); ++index) {
    const char* const sign_and_name = sqlite3_bind_parameter_name(statement, index);
    const bool is_numbered = sign_and_name != nullptr && *sign_and_name == '?';
    const std::string name = sign_and_name == nullptr || is_numbered ? "" : sign_and_name + 1;
    if (!name.empty()) ++named;
    // SQLite's indices also count parameters with names; ?2 is the second one in any case.
    const int wanted = is_numbered ? index : index - named;
    int unnamed_before = 0;
    const auto found = std::ranges::find_if(values, [&](const SqlParameter& parameter) {
      return parameter.name == name && (!name.empty() || ++unnamed_before == wanted);
    });
    if (found == values.end())
      throw input_error(
          "missing value of parameter " + (name.empty() ? std::to_string(wanted) : sign_and_name),
          name.empty() ? "--param VALUE for each, in order" : fmt::format("--param {}=VALUE", name));
    is_used[static_cast<std::size_t>(found - values.begin())] = true;
    bind(statement, index, found->value);
  }
}

/// All statements of the text, with values for their parameters.
std::vector<database::Prepared> prepare_all(sqlite3* database, const SqlText& sql,
                                            const SqlParameters& parameters) {
  std::vector<database::Prepared> statements;
  std::vector<bool> is_used(parameters.values.size());
  const database::TokenList tokens(sql.text);
  std::size_t end = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (tokens[i].begin < end || tokens.is_sign(i, ";")) continue;
    const std::size_t begin = tokens[i].begin;
    const auto check = [&](bool reads, std::string found) {
      if (!reads)
        throw Error(sql.name, database::text_location(sql.text, begin), "the statement is not read-only",
                    "SELECT, WITH, VALUES or EXPLAIN", std::move(found));
    };
    // Some statements that write do so beside the database, which is open for reading only.
    check(tokens.is_one_of(i, {"select", "with", "values", "explain"}), std::string(tokens.text(i)));
    statements.push_back(database::prepare(database, sql.text, begin, sql.name));
    sqlite3_stmt* const statement = statements.back().statement.get();
    check(sqlite3_stmt_readonly(statement) != 0, "a statement that writes");
    end = begin + statements.back().size;
    bind_all(statement, parameters.values, is_used);
  }
  const auto unused = std::ranges::find(is_used, false) - is_used.begin();
  if (parameters.are_all_used && unused < std::ssize(is_used)) {
    const std::string& name = parameters.values[static_cast<std::size_t>(unused)].name;
    throw file_error("--param", name.empty() ? fmt::format("no parameter for value {}", unused + 1)
                                             : fmt::format("unknown parameter :{}", name));
  }
  return statements;
}

SqlValue column_value(sqlite3_stmt* statement, int column) {
  const auto size = [&] { return static_cast<std::size_t>(sqlite3_column_bytes(statement, column)); };
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return sqlite3_column_int64(statement, column);
    case SQLITE_FLOAT:
      return sqlite3_column_double(statement, column);
    case SQLITE_TEXT: {
      const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
      return text == nullptr ? std::string() : std::string(text, size());
    }
    case SQLITE_BLOB: {
      const auto* const bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement, column));
      return std::vector<std::byte>(bytes, bytes + size());
    }
    default:
      return {};
  }
}

database::ScanReads reads_since(const database::ScanReads& before, const database::ScanReads& now) {
  return {now.scans - before.scans, now.chunks - before.chunks, now.chunks_read - before.chunks_read,
          now.points_read - before.points_read, now.rows_given - before.rows_given};
}

void run_one(const database::Connection& connection, database::Prepared& prepared, const RowSink& sink) {
  const auto start = std::chrono::steady_clock::now();
  const database::ScanReads before = connection.reads();
  sqlite3_stmt* const statement = prepared.statement.get();
  std::vector<SqlValue> values(static_cast<std::size_t>(sqlite3_column_count(statement)));
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < values.size(); ++i)
    columns.emplace_back(sqlite3_column_name(statement, static_cast<int>(i)));
  sink.begin(columns);
  StatementReport report{.rewritten = prepared.pruned, .reason = prepared.reason};
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(statement)) == SQLITE_ROW) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = column_value(statement, static_cast<int>(i));
    sink.row(values);
    ++report.rows;
  }
  if (result == SQLITE_INTERRUPT) throw Cancelled();
  if (result != SQLITE_DONE)
    throw file_error(database::file_of(connection.get()), sqlite3_errmsg(connection.get()));
  prepared.statement.reset();
  report.reads = reads_since(before, connection.reads());
  report.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  sink.end(report);
}

/// Returns work(). An interrupted wait for a lock ends as an error of the locked file.
template <class Work>
auto or_cancelled(const Listener& listener, const Work& work) {
  try {
    return work();
  } catch (const Error&) {
    if (listener.stops()) throw Cancelled();
    throw;
  }
}

}  // namespace

void add_sql_source(const Fields& fields, const std::string& statement_help, const std::string& file_help,
                    SqlSource& source) {
  const Field statement = fields.text("statement", "STATEMENT", statement_help, source.statement);
  fields.excludes(statement).file("-f,--file", "FILE", file_help, source.file);
}

SqlText read_sql(const SqlSource& source) {
  const bool is_input = is_standard_input(source);
  if (source.statement && !is_input) return {*source.statement, "statement"};
  const std::string file = is_input ? "-" : source.file.string();
  if (!is_input && std::filesystem::is_directory(source.file))
    throw Error({.file = file, .problem = "cannot read the file", .found = "a folder"});
  std::ifstream opened;
  if (!is_input) opened.open(source.file, std::ios::binary);
  // /dev/stdin cannot be opened where standard input is a socket, as Node makes it for its children.
  std::istream& stream = is_input ? std::cin : opened;
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) throw file_error(file, "cannot read the file");
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos)
    throw Error(file, database::text_location(text, nul), "the file contains a NUL byte", {}, "0");
  return {std::move(text), is_input ? "standard input" : file};
}

void add_sql_fields(const Fields& fields, SqlRequest& request, const std::function<void()>& add_answers) {
  fields.file("cloud", "CLOUD",
              "SQLite file with clouds; or a cloud: a file, folder, pattern or catalog, as the table points",
              request.cloud);
  add_sql_source(fields, "SQL to run; - reads standard input; without it a terminal opens a prompt",
                 "run the statements of a file", request.source);
  fields.values("--param", "VALUE",
                "value of ? (in order) or, as name=VALUE, of :name; NULL, a number or text",
                [&values = request.parameters.values](const std::string& text) {
                  values.push_back(parse_sql_parameter(text));
                });
  add_answers();
  add_partial(fields, request.partial);
  add_remote_fields(fields);
}

SqlPlan plan(const SqlRequest& request) {
  if (request.cloud.empty()) {
    throw input_error("missing cloud or database",
                      "alidade sql CLOUD \"SELECT ...\", or alidade sql load FILE... DB");
  }
  if (const AddedFormat* const server = server_of(request.cloud.string())) {
    throw file_error(server->shown(request.cloud.string()), "not an SQLite file but a server",
                     "an SQLite file or cloud files (for a server, use psql with the alidade_pg extension)");
  }
  if (database::k_sqlite_format.is_named(request.cloud.string())) {
    throw file_error(request.cloud, "the name of a cloud in a database",
                     "the name of the file; statements name its tables");
  }
  const bool is_database = names_database(request.cloud);
  if (is_database && request.partial)
    throw file_error(request.cloud, "--partial does not apply to databases", "no --partial");
  return SqlPlan({request, is_database,
                  is_standard_input(request.source) ? std::nullopt : std::optional(read_sql(request.source))},
                 {.reads = {request.cloud, request.source.file}});
}

std::unique_ptr<database::Connection> open_cloud(const CheckedSql& request, Listener& listener) {
  using database::Connection;
  const auto stops = [&listener] { return listener.stops(); };
  return or_cancelled(listener, [&] {
    if (request.is_database)
      return std::make_unique<Connection>(request.cloud, Connection::Mode::read, stops);
    // A file that is read in place has no stage.
    std::unique_ptr<Listener::Stage> stage;
    Progress show;
    const Progress progress = [&](std::uint64_t done, std::uint64_t total) {
      if (!stage) {
        stage = listener.begin("reading", "B");
        show = stage->callback();
      }
      return show(done, total);
    };
    auto connection = std::make_unique<Connection>(
        std::span(&request.cloud, 1),
        database::FileTables{
            .reading = {.partial = request.partial, .progress = progress},
            .is_given_up = stops,
            .warn = [&](const std::vector<std::string>& warnings) { warn_all(listener, warnings); }});
    if (stage) stage->finish();
    return connection;
  });
}

void run_statements(const database::Connection& connection, const SqlText& sql,
                    const SqlParameters& parameters, const RowSink& sink, Listener& listener) {
  constexpr int k_steps = 1000;
  sqlite3_progress_handler(
      connection.get(), k_steps,
      [](void* heard) { return static_cast<const Listener*>(heard)->stops() ? 1 : 0; }, &listener);
  or_cancelled(listener, [&] {
    for (database::Prepared& prepared : prepare_all(connection.get(), sql, parameters))
      run_one(connection, prepared, sink);
  });
}

void run(const SqlPlan& plan, const RowSink& sink, Listener& listener) {
  const CheckedSql& request = plan.request();
  const std::unique_ptr<database::Connection> connection = open_cloud(request, listener);
  run_statements(*connection, request.text ? *request.text : read_sql(request.source), request.parameters,
                 sink, listener);
}

SqlResult run(const SqlPlan& plan, Listener& listener) {
  if (!plan.request().text) throw input_error("missing statement", "--statement or --file");
  SqlResult results;
  run(plan,
      {.begin =
           [&](const std::vector<std::string>& columns) {
             results.push_back({columns, std::vector<std::vector<SqlValue>>(columns.size()), {}});
           },
       .row =
           [&](std::span<const SqlValue> row) {
             for (std::size_t i = 0; i < row.size(); ++i) results.back().values[i].push_back(row[i]);
           },
       .end = [&](const StatementReport& report) { results.back().report = report; }},
      listener);
  return results;
}

}  // namespace alidade::jobs
