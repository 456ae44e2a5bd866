// SPDX-License-Identifier: MIT
#include <filesystem>
#include <memory>

#include "database/sqlite/connection.h"
#include "database/sqlite/statement.h"
#include "tools/command.h"
#include "tools/message.h"
#include "tools/sql_load.h"
#include "tools/sql_shard_plan.h"

namespace alidade {
namespace {

struct SqlCommand {
  std::filesystem::path database;
  std::string statement;
};

ExitCode run(const SqlCommand& command) {
  const Connection connection(command.database, Connection::Mode::read);
  Statement statement(connection.get(), command.statement);
  while (statement.step()) write_to_stdout(statement.text(0) + "\n");
  return ExitCode::done;
}

}  // namespace

Command add_sql(CLI::App& program) {
  CLI::App* const sql = program.add_subcommand("sql", "Ask clouds that lie in a database");
  const auto command = std::make_shared<SqlCommand>();
  sql->add_option("database", command->database, "SQLite file")->option_text("DB");
  sql->add_option("statement", command->statement, "SQL")->option_text("STATEMENT");
  // Not finished: not in the manual.
  sql->group("");
  const std::vector<Command> parts = {add_sql_load(*sql), add_sql_shard_plan(*sql)};
  return {
      sql,
      [command, parts, sql] { return sql->get_subcommands().empty() ? run(*command) : run_chosen(parts); },
      parts};
}

}  // namespace alidade
