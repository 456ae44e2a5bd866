// SPDX-License-Identifier: MIT
#include <unistd.h>
#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "base/words.h"
#include "database/server/server_name.h"
#include "database/sqlite/stored_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/sql/statements.h"
#include "tools/view_options.h"

namespace alidade::tools {
namespace {

struct SqlCommand : RunRequest {
  std::filesystem::path cloud, file;
  std::string statement;
  bool has_statement = false, csv = false, json = false, explain = false;
  std::vector<std::string> parameters;
};

/// By extension, so that missing and damaged databases count too, and by content.
bool is_database(const std::filesystem::path& name) {
  constexpr const char* k_databases[] = {".db", ".db3", ".sqlite", ".sqlite3", ".gpkg"};
  if (std::ranges::find(k_databases, file_extension(name)) != std::end(k_databases)) return true;
  const CloudInputs inputs = resolve_clouds(std::span(&name, 1), cloud_formats());
  return inputs.only(database::k_sqlite_format) != nullptr;
}

std::unique_ptr<database::Connection> open_for_reading(const SqlCommand& command) {
  using database::Connection;
  try {
    if (is_database(command.cloud)) {
      if (command.partial)
        throw file_error(command.cloud, "--partial does not apply to databases", "no --partial");
      return std::make_unique<Connection>(command.cloud, Connection::Mode::read, interrupted);
    }
    ProgressLine line("reading", "B", command.verbosity);
    bool has_begun = false;  // a file that is read in place shows no progress
    const Progress progress = [&, show = line.callback()](std::uint64_t done, std::uint64_t total) {
      has_begun = true;
      return show(done, total);
    };
    auto connection = std::make_unique<Connection>(
        std::span(&command.cloud, 1),
        database::FileTables{.reading = {.partial = command.partial, .progress = progress},
                             .is_given_up = interrupted,
                             .warn = [&](const std::vector<std::string>& warnings) {
                               say_warnings(command.verbosity, warnings);
                             }});
    if (has_begun) line.finish();
    return connection;
  } catch (const Error&) {
    // An interrupted wait for a lock ends as an error of the locked file.
    if (interrupted()) throw Cancelled();
    throw;
  }
}

ExitCode run(const SqlCommand& command) {
  if (command.cloud.empty()) {
    throw input_error("missing cloud or database",
                      "alidade sql CLOUD \"SELECT ...\", or alidade sql load FILE... DB");
  }
  if (database::is_server_name(command.cloud.string())) {
    throw file_error(database::ServerName(command.cloud.string()).shown(), "not an SQLite file but a server",
                     "an SQLite file or cloud files (for a server, use psql with the alidade_pg extension)");
  }
  SqlRun run{.form = command.csv    ? RowForm::csv
                     : command.json ? RowForm::json
                                    : RowForm::table,
             .explain = command.explain};
  for (const std::string& text : command.parameters) run.parameters.push_back(parse_sql_parameter(text));
  const std::unique_ptr<database::Connection> opened = open_for_reading(command);
  const database::Connection& connection = *opened;
  // An empty statement is one, too: in a script a variable may be empty, and a prompt would wait for ever.
  if (command.has_statement && command.statement != "-") {
    run_statements(connection, command.statement, "statement", std::move(run));
    return ExitCode::done;
  }
  const bool on_terminal = ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1;
  if (command.file.empty() && !command.has_statement && on_terminal) {
    run_prompt(connection, command.cloud.string(), std::move(run));
    return ExitCode::done;
  }
  const std::filesystem::path file = command.file.empty() ? "-" : command.file;
  run_statements(connection, read_sql(file), file == "-" ? "standard input" : file.string(), std::move(run));
  return ExitCode::done;
}

}  // namespace

Command add_sql(const Options& program) {
  const Options sql =
      program.command("sql", "Query clouds in files or databases with SQL, and load databases");
  const auto command = std::make_shared<SqlCommand>();
  sql.file("cloud", "CLOUD",
           "SQLite file with clouds; or a cloud: a file, folder, pattern or catalog, as the table points",
           command->cloud);
  const Option statement = sql.text(
      "statement", "STATEMENT", "SQL to run; - reads standard input; without it a terminal opens a prompt",
      command->statement);
  sql.excludes(statement).file("-f,--file", "FILE", "run the statements of a file", command->file);
  sql.text("--param", "VALUE", "value of ? (in order) or, as name=VALUE, of :name; NULL, a number or text",
           command->parameters);
  const Option csv = sql.flag("--csv", "rows as CSV with a header", command->csv);
  sql.excludes(csv).flag("--json", "rows as an array of objects", command->json);
  sql.flag("--explain", "print what was read, the time, and how the statement was rewritten, or why not",
           command->explain);
  add_run_options(sql, *command);
  add_cache_options(sql);
  Command added = command_of(sql, command, run);
  added.run = [command, statement, with_words = added.run](const CommandLine& words) {
    command->has_statement = statement.given();
    return with_words(words);
  };
  added.parts = {add_sql_load(sql), add_sql_rewrite(sql), add_sql_shard_plan(sql)};
  return added;
}

}  // namespace alidade::tools
