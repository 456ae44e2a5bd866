// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "base/error.h"
#include "database/server/server_name.h"
#include "database/sqlite/sql_tokens.h"
#include "tools/command.h"
#include "tools/console.h"
#include "tools/sql/statements.h"

namespace alidade::tools {
namespace {

struct SqlCommand {
  std::filesystem::path database, file;
  std::string statement;
  bool csv = false, json = false, explain = false;
  std::vector<std::string> parameters;
};

/// All of a file; "-" is standard input.
std::string read_text(const std::filesystem::path& file) {
  if (file != "-" && std::filesystem::is_directory(file)) {
    throw Error({.file = file.string(), .problem = "cannot be read", .found = "a folder"});
  }
  std::ifstream stream(file == "-" ? "/dev/stdin" : file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) throw Error({.file = file.string(), .problem = "cannot be read"});
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos) {
    throw Error({.file = file.string(),
                 .place = database::text_place(text, nul),
                 .problem = "a byte that is no text",
                 .found = "0"});
  }
  return text;
}

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
  if (command.database.empty()) {
    throw Error({.problem = "no database is given",
                 .expected = "alidade sql DB \"SELECT ...\", or alidade sql load FILE... DB"});
  }
  if (database::is_server_name(command.database.string())) {
    throw Error(
        {.file = database::ServerName(command.database.string()).shown(),
         .problem = "a server is asked with psql, where the extension alidade_pg leaves as much unread",
         .expected = "an SQLite file"});
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
  run_statements(connection, read_text(file), file == "-" ? "standard input" : file.string(), std::move(run));
  return ExitCode::done;
}

}  // namespace

Command add_sql(CLI::App& program) {
  CLI::App* const sql = program.add_subcommand("sql", "Ask clouds in a database with SQL; load them there");
  const auto command = std::make_shared<SqlCommand>();
  sql->add_option("database", command->database, "SQLite file with clouds")->option_text("DB");
  CLI::Option* const statement =
      sql->add_option("statement", command->statement,
                      "SQL to run; - reads it from standard input; without it a terminal gets a prompt")
          ->option_text("STATEMENT");
  sql->add_option("-f,--file", command->file, "run the statements of a file")
      ->option_text("FILE")
      ->excludes(statement);
  sql->add_option("--param", command->parameters,
                  "value for ? (in their order) or, as name=VALUE, for :name; NULL, a number or text")
      ->option_text("VALUE")
      ->allow_extra_args(false);
  CLI::Option* const csv =
      sql->add_flag("--csv", command->csv, "rows as CSV with a header")->option_text(" ");
  sql->add_flag("--json", command->json, "rows as an array of objects")->option_text(" ")->excludes(csv);
  sql->add_flag("--explain", command->explain,
                "say what was read, how long it took, and how the statement was rewritten, or why not")
      ->option_text(" ");
  sql->footer(
      "Forms:\n"
      "  alidade sql load FILE... DB         stores clouds; see 'alidade sql load --help'\n"
      "  alidade sql shard-plan CLOUD...     plans a cloud for several servers; see its --help\n"
      "  alidade sql DB STATEMENT [OPTIONS]  runs SELECT and other statements of SQLite that read\n"
      "  alidade sql DB                      a prompt, with line editing and history; .help tells its "
      "commands\n"
      "\n"
      "A cloud is a table with the columns id, x, y, z and its attributes. Every statement has the "
      "functions\n"
      "  dist_ray(ox,oy,oz, dx,dy,dz, x,y,z)    distance of a point to the line through o along d\n"
      "  dist_plane(px,py,pz, nx,ny,nz, x,y,z)  signed distance to the plane through p across n\n"
      "Conditions on them (<, <=, =, >=, >, BETWEEN) and on x, y, z leave chunks of points unread that have "
      "none.\n"
      "points(ox,oy,oz, dx,dy,dz) is the cloud with the columns dist and t of that ray; sorted by one of "
      "these it\n"
      "is read only as far as rows are taken. Lengths are in the unit of the coordinates, mostly metres;\n"
      "directions may have any length but zero.\n"
      "\n"
      "Examples:\n"
      "  alidade sql site.db \"SELECT * FROM points WHERE dist_ray(0,0,1.5, 1,0.2,0, x,y,z) <= 1\" "
      "--explain\n"
      "  alidade sql site.db \"SELECT id, t FROM points(0,0,2, 1,0,0) WHERE dist <= 1 ORDER BY t LIMIT 1\" "
      "--json\n"
      "  alidade sql site.db \"SELECT avg(z) FROM points WHERE x BETWEEN ? AND ?\" --param 10 --param 20 "
      "--csv\n");
  const std::vector<Command> parts = {add_sql_load(*sql), add_sql_shard_plan(*sql)};
  return {sql,
          [command, parts, sql, statement] {
            return sql->get_subcommands().empty() ? run(*command, statement->count() > 0) : run_chosen(parts);
          },
          parts};
}

}  // namespace alidade::tools
