// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "base/error.h"
#include "database/server/server_name.h"
#include "tools/command.h"
#include "tools/sql/statements.h"

namespace alidade::tools {
namespace {

struct SqlCommand {
  std::filesystem::path database, file;
  std::string statement;
  bool csv = false, json = false, explain = false;
  std::vector<std::string> parameters;
};

std::unique_ptr<database::Connection> open_for_reading(const std::filesystem::path& database) {
  try {
    return std::make_unique<database::Connection>(database, database::Connection::Mode::read, interrupted);
  } catch (const Error&) {
    // Such as that the file is locked, once nobody waits any more.
    if (interrupted()) throw Cancelled();
    throw;
  }
}

ExitCode run(const SqlCommand& command, bool has_statement) {
  if (command.database.empty())
    throw input_error("missing database", "alidade sql DB \"SELECT ...\", or alidade sql load FILE... DB");
  if (database::is_server_name(command.database.string())) {
    throw file_error(database::ServerName(command.database.string()).shown(),
                     "not an SQLite file but a server",
                     "an SQLite file (for a server, use psql with the alidade_pg extension)");
  }
  SqlRun run{.form = command.csv    ? RowForm::csv
                     : command.json ? RowForm::json
                                    : RowForm::table,
             .explain = command.explain};
  for (const std::string& text : command.parameters) run.parameters.push_back(parse_sql_parameter(text));
  const std::unique_ptr<database::Connection> opened = open_for_reading(command.database);
  const database::Connection& connection = *opened;
  // An empty statement is one, too: what a script puts there may be empty, and nobody would type at a prompt.
  if (has_statement && command.statement != "-") {
    run_statements(connection, command.statement, "statement", std::move(run));
    return ExitCode::done;
  }
  const bool on_terminal = ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1;
  if (command.file.empty() && !has_statement && on_terminal) {
    run_prompt(connection, command.database.string(), std::move(run));
    return ExitCode::done;
  }
  const std::filesystem::path file = command.file.empty() ? "-" : command.file;
  run_statements(connection, read_sql(file), file == "-" ? "standard input" : file.string(), std::move(run));
  return ExitCode::done;
}

}  // namespace

Command add_sql(const Options& program) {
  const Options sql = program.command("sql", "Query clouds in a database with SQL, and load them");
  const auto command = std::make_shared<SqlCommand>();
  sql.file("database", "DB", "SQLite file with clouds", command->database);
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
  return {sql,
          [command, statement](const CommandLine&) { return run(*command, statement.given()); },
          {add_sql_load(sql), add_sql_rewrite(sql), add_sql_shard_plan(sql)}};
}

}  // namespace alidade::tools
