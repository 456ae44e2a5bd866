// SPDX-License-Identifier: MIT
#include "tools/sql/prompt.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

#include "base/error.h"
#include "database/sqlite/sql_tokens.h"
#include "tools/interrupt.h"
#include "tools/message.h"
#include "tools/sql/line_editor.h"

namespace alidade {
namespace {

constexpr const char* k_commands =
    "STATEMENT;             run it\n"
    ".tables                clouds, tables and views\n"
    ".schema [TABLE]        columns\n"
    ".mode table|csv|json   how rows are printed\n"
    ".explain on|off        whether to tell what was read\n"
    ".help                  this\n"
    ".quit                  or Ctrl-D: leave\n";

constexpr const char* k_tables =
    "SELECT name, CASE type WHEN 'virtual' THEN 'cloud' ELSE type END AS type FROM pragma_table_list "
    "WHERE schema = 'main' AND type IN ('table', 'view', 'virtual') AND name NOT LIKE 'sqlite\\_%' ESCAPE "
    "'\\' "
    "ORDER BY name";

constexpr const char* k_columns =
    "SELECT t.name AS \"table\", c.name AS \"column\", c.type, iif(c.hidden = 1, 'hidden', '') AS \"in *\" "
    "FROM pragma_table_list t, pragma_table_xinfo(t.name) c "
    "WHERE t.schema = 'main' AND t.type IN ('table', 'view', 'virtual') AND t.name NOT LIKE 'sqlite\\_%' "
    "ESCAPE '\\' "
    "AND (?1 IS NULL OR t.name = ?1 COLLATE NOCASE) ORDER BY t.name, c.cid";

class Prompt {
 public:
  Prompt(const Connection& connection, SqlRun run)
      : connection_(connection), run_(std::move(run)), editor_(sql_history_file()) {
    // Those of one statement may not be those of the next.
    run_.are_all_used = false;
  }

  void run() {
    while (!is_done_) {
      const std::optional<std::string> line = editor_.read(typed_.empty() ? "alidade> " : "     ...> ");
      if (line) {
        take(*line);
      } else if (interrupted()) {
        start_anew();
      } else {
        is_done_ = true;
        write_to_stdout("\n");
      }
    }
  }

 private:
  void take(const std::string& line) {
    try {
      if (typed_.empty() && line.starts_with(".")) {
        command(line);
        return;
      }
      typed_ += line + "\n";
      const bool is_in_comment = sqlite3_complete((typed_ + ";").c_str()) == 0;
      if (sql_tokens(typed_).empty() && !is_in_comment) typed_.clear();
      if (sqlite3_complete(typed_.c_str()) != 0)
        run_statements(connection_, std::exchange(typed_, {}), "statement", run_);
    } catch (const Error& error) {
      say_error(error.what());
    } catch (const Cancelled&) {
      start_anew();
    }
  }

  void start_anew() {
    if (!forget_ctrl_c()) throw Cancelled();
    typed_.clear();
    write_to_stdout("\n");
  }

  void command(const std::string& line) {
    std::istringstream words(line);
    std::string name, value, more;
    words >> name >> value >> more;
    constexpr std::array<std::pair<const char*, RowForm>, 3> k_forms = {
        {{"table", RowForm::table}, {"csv", RowForm::csv}, {"json", RowForm::json}}};
    const auto form =
        std::ranges::find(k_forms, value, [](const auto& known) { return std::string(known.first); });
    if (!more.empty()) name.clear();
    if (name == ".quit" || name == ".exit") {
      is_done_ = true;
    } else if (name == ".help") {
      write_to_stdout(k_commands);
    } else if (name == ".tables") {
      run_statements(connection_, k_tables, name, {.form = run_.form});
    } else if (name == ".schema") {
      SqlParameter table;
      if (!value.empty()) table.value = value;
      run_statements(connection_, k_columns, name, {.form = run_.form, .parameters = {table}});
    } else if (name == ".mode" && form != k_forms.end()) {
      run_.form = form->second;
    } else if (name == ".explain" && (value == "on" || value == "off")) {
      run_.explain = value == "on";
    } else {
      refuse(line);
    }
  }

  [[noreturn]] static void refuse(const std::string& line) {
    throw Error({.problem = "no such command", .expected = "one that .help tells", .found = line});
  }

  const Connection& connection_;
  SqlRun run_;
  LineEditor editor_;
  std::string typed_;  ///< of a statement that has not ended
  bool is_done_ = false;
};

}  // namespace

void run_prompt(const Connection& connection, const std::string& database, SqlRun run) {
  say_note(database + " is open for reading; .help tells the commands");
  Prompt(connection, std::move(run)).run();
}

}  // namespace alidade
