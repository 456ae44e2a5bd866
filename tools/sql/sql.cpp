// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "database/server/server_name.h"
#include "database/sqlite/sql_tokens.h"
#include "database/sqlite/sqlite_api.h"
#include "database/sqlite/stored_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/sql/statements.h"

namespace alidade::tools {
namespace {

constexpr int k_kept_lines = 1000;

/// The next byte of stdin; EOF at its end and when the program is interrupted.
int read_byte() {
  while (!interrupted()) {
    unsigned char byte = 0;
    const ::ssize_t count = ::read(STDIN_FILENO, &byte, 1);
    if (count == 1) return byte;
    if (count == 0 || errno != EINTR) break;
  }
  return EOF;
}

/// The next character, as its Unicode code point for libedit, whose own reading would not end at Ctrl-C.
/// Bytes that are not UTF-8 become U+FFFD, or nothing if another key interrupts the character.
int read_character(FILE*) {
  constexpr int k_replacement = 0xfffd;
  int code = 0, missing = 0;
  while (true) {
    const int byte = read_byte();
    if (byte == EOF || byte < 0x80) return byte;
    if (byte >= 0xf8) return k_replacement;
    if (byte >= 0xc0) {
      missing = byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
      code = byte & (0x3f >> missing);
      continue;
    }
    if (missing == 0) return k_replacement;
    code = code << 6 | (byte & 0x3f);
    if (--missing > 0) continue;
    const bool is_code_point = code >= 0x80 && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff);
    return is_code_point ? code : k_replacement;
  }
}

std::optional<std::string> read_plain_line(const std::string& prompt) {
  write_to_stdout(prompt);
  std::string line;
  for (int byte = read_byte(); byte != '\n'; byte = read_byte()) {
    if (byte == EOF) return std::nullopt;
    line += static_cast<char>(byte);
  }
  return line;
}

/// The part of libedit that has readline's names.
struct EditLibrary {
  char* (*read_line)(const char*) = nullptr;
  int (*add_history)(const char*) = nullptr;
  int (*read_history)(const char*) = nullptr;
  int (*write_history)(const char*) = nullptr;
  void (*stifle_history)(int) = nullptr;

  /// Null if the library is missing, or not the expected one.
  static std::unique_ptr<EditLibrary> load() {
    void* const handle = ::dlopen("libedit.so.2", RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return nullptr;
    auto library = std::make_unique<EditLibrary>();
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(handle, name));
      return function != nullptr;
    };
    int* catches_signals = nullptr;
    int (**next_character)(FILE*) = nullptr;
    if (!find(library->read_line, "readline") || !find(library->add_history, "add_history") ||
        !find(library->read_history, "read_history") || !find(library->write_history, "write_history") ||
        !find(library->stifle_history, "stifle_history") || !find(catches_signals, "rl_catch_signals") ||
        !find(next_character, "rl_getc_function"))
      return nullptr;
    // Characters beyond ASCII can be edited only if the locale has them.
    if (std::setlocale(LC_CTYPE, "") == nullptr || MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
    *catches_signals = 0;
    *next_character = read_character;
    return library;
  }
};

/// The file of the prompt's history: $XDG_STATE_HOME/alidade/sql_history, or below ~/.local/state; empty if
/// there is no home.
std::filesystem::path sql_history_file() {
  const auto folder = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  if (const std::filesystem::path state = folder("XDG_STATE_HOME"); state.is_absolute())
    return state / "alidade" / "sql_history";
  const std::filesystem::path home = folder("HOME");
  return home.empty() ? home : home / ".local" / "state" / "alidade" / "sql_history";
}

/// Lines typed at a terminal, with editing and history as in a shell. That is libedit's work, which is loaded
/// only here; without it lines are read as the terminal sends them.
class LineEditor {
 public:
  /// Earlier lines come from that file, if it can be read.
  explicit LineEditor(std::filesystem::path history)
      : history_(std::move(history)), library_(EditLibrary::load()) {
    if (library_ == nullptr) return;
    library_->stifle_history(k_kept_lines);
    if (!history_.empty()) library_->read_history(history_.c_str());
  }

  /// Writes the last 1000 lines to it, if it can be written.
  ~LineEditor() {
    if (library_ == nullptr || history_.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(history_.parent_path(), error);
    // For the user alone.
    const ::mode_t before = ::umask(0077);
    library_->write_history(history_.c_str());
    ::umask(before);
  }
  LineEditor(const LineEditor&) = delete;
  LineEditor& operator=(const LineEditor&) = delete;

  /// Waits for a line; empty at the end of input, or if the program was interrupted meanwhile.
  std::optional<std::string> read(const std::string& prompt) {
    if (library_ == nullptr) return read_plain_line(prompt);
    char* const typed = library_->read_line(prompt.c_str());
    if (typed == nullptr) return std::nullopt;
    std::string line = typed;
    std::free(typed);
    if (interrupted()) return std::nullopt;
    if (!line.empty()) library_->add_history(line.c_str());
    return line;
  }

 private:
  std::filesystem::path history_;
  std::unique_ptr<EditLibrary> library_;
};

constexpr const char* k_commands =
    "STATEMENT;             run it\n"
    ".tables                clouds, tables and views\n"
    ".schema [TABLE]        columns\n"
    ".mode table|csv|json   output format\n"
    ".explain on|off        print what was read\n"
    ".help                  this text\n"
    ".quit                  or Ctrl-D: exit\n";

constexpr const char* k_tables =
    "SELECT name, CASE type WHEN 'virtual' THEN 'cloud' ELSE type END AS type FROM pragma_table_list WHERE "
    "schema = 'main' AND type IN ('table', 'view', 'virtual') AND name NOT LIKE 'sqlite\\_%' ESCAPE '\\' "
    "ORDER BY name";

constexpr const char* k_columns =
    "SELECT t.name AS \"table\", c.name AS \"column\", c.type, iif(c.hidden = 1, 'hidden', '') AS \"in *\" "
    "FROM pragma_table_list t, pragma_table_xinfo(t.name) c WHERE t.schema = 'main' AND t.type IN ('table', "
    "'view', 'virtual') AND t.name NOT LIKE 'sqlite\\_%' ESCAPE '\\' AND (?1 IS NULL OR t.name = ?1 COLLATE "
    "NOCASE) ORDER BY t.name, c.cid";

class Prompt {
 public:
  Prompt(const database::Connection& connection, SqlRun run)
      : connection_(connection), run_(std::move(run)), editor_(sql_history_file()) {
    // The next statement may have other parameters.
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
      if (database::sql_tokens(typed_).empty() && !is_in_comment) typed_.clear();
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
      reject(line);
    }
  }

  [[noreturn]] static void reject(const std::string& line) {
    throw input_error("unknown command", "a command listed by .help", line);
  }

  const database::Connection& connection_;
  SqlRun run_;
  LineEditor editor_;
  std::string typed_;  ///< of a statement that has not ended
  bool is_done_ = false;
};

/// Reads statements at the terminal and runs them, until the end of input or .quit. A statement ends with a
/// semicolon and may take several lines; a line that begins with a dot is a command of the prompt (.help).
/// After errors, which are reported, the prompt continues; so it does after Ctrl-C, which drops what is typed
/// or runs. Other signals are thrown as Cancelled.
void run_prompt(const database::Connection& connection, const std::string& database, SqlRun run) {
  say_note(database + " is open for reading; .help lists the commands");
  Prompt(connection, std::move(run)).run();
}

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
  const Field statement = sql.text("statement", "STATEMENT",
                                   "SQL to run; - reads standard input; without it a terminal opens a prompt",
                                   command->statement);
  sql.excludes(statement).file("-f,--file", "FILE", "run the statements of a file", command->file);
  sql.text("--param", "VALUE", "value of ? (in order) or, as name=VALUE, of :name; NULL, a number or text",
           command->parameters);
  const Field csv = sql.flag("--csv", "rows as CSV with a header", command->csv);
  sql.excludes(csv).flag("--json", "rows as an array of objects", command->json);
  sql.flag("--explain", "print what was read, the time, and how the statement was rewritten, or why not",
           command->explain);
  add_run_options(sql, *command);
  add_remote_fields(sql);
  Command added = command_of(sql, command, run);
  added.run = [command, statement, with_words = added.run](const CommandLine& words) {
    command->has_statement = statement.given();
    return with_words(words);
  };
  added.parts = {add_sql_load(sql), add_sql_rewrite(sql), add_sql_shard_plan(sql)};
  return added;
}

}  // namespace alidade::tools
