// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cwchar>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/shown_text.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/sqlite_api.h"
#include "jobs/sql/load.h"
#include "jobs/sql/rewrite.h"
#include "jobs/sql/row_text.h"
#include "jobs/sql/statement.h"
#include "tools/command.h"

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

/// The next character, as its code point for libedit, whose own reading would not end at Ctrl-C. Invalid bytes
/// become U+FFFD, or nothing if another key interrupts the character.
int read_character(FILE*) {
  constexpr auto k_invalid = static_cast<std::size_t>(-1), k_incomplete = static_cast<std::size_t>(-2);
  std::mbstate_t state{};
  for (int byte = read_byte(); byte != EOF; byte = read_byte()) {
    const char text = static_cast<char>(byte);
    wchar_t code = 0;
    std::size_t size = std::mbrtowc(&code, &text, 1, &state);
    if (size == k_invalid) size = std::mbrtowc(&code, &text, 1, &(state = {}));
    if (size == k_invalid) return 0xfffd;
    if (size != k_incomplete) return static_cast<int>(code);
  }
  return EOF;
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

/// How rows of statements are printed.
struct SqlShow {
  jobs::SqlForm form = jobs::SqlForm::table;
  bool explain = false;  ///< after the rows of each statement, print what was read, and whether it was pruned
};

/// A statement keeps its lines: they are the user's own.
void say_rewritten(std::string_view statement) {
  std::string text = "alidade: rewritten as: ";
  for (std::size_t begin = 0; begin <= statement.size();) {
    const std::size_t end = std::min(statement.find('\n', begin), statement.size());
    text += line_text(statement.substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  write_to_stderr(text);
}

void explain(const jobs::StatementReport& report) {
  const database::ScanReads& reads = report.reads;
  std::string text = "read no cloud";
  if (reads.scans > 0) text = fmt::format("read {} of {} chunks", reads.chunks_read, reads.chunks);
  if (reads.chunks > 0)
    text += fmt::format(" ({:.1f} %)",
                        100.0 * static_cast<double>(reads.chunks_read) / static_cast<double>(reads.chunks));
  if (reads.scans > 1) text += fmt::format(" in {} scans", reads.scans);
  if (reads.scans > 0) text += fmt::format(", {} points tested", reads.points_read);
  say_note(fmt::format("{}, {} {}, {:.1f} ms", text, report.rows, report.rows == 1 ? "row" : "rows",
                       report.milliseconds));
  if (!report.rewritten.empty()) say_rewritten(report.rewritten);
  if (!report.reason.empty())
    say_note((report.rewritten.empty() ? "not rewritten: " : "not rewritten further: ") + report.reason);
}

/// Prints rows on stdout, and explanations on stderr.
jobs::RowSink printed_rows(SqlShow show) {
  jobs::RowSink rows = jobs::row_text(show.form, write_to_stdout);
  if (show.explain)
    rows.end = [end = rows.end](const jobs::StatementReport& report) {
      end(report);
      explain(report);
    };
  return rows;
}

/// Reads statements at the terminal and runs them, until the end of input or .quit. A statement ends with a
/// semicolon and may take several lines; a line that begins with a dot is a command of the prompt (.help).
/// After errors, which are reported, the prompt continues; so it does after Ctrl-C, which drops what is typed
/// or runs. Other signals are thrown as Cancelled.
class Prompt {
 public:
  Prompt(const database::Connection& connection, jobs::SqlParameters parameters, SqlShow show,
         Console& console)
      : connection_(connection),
        parameters_(std::move(parameters)),
        show_(show),
        console_(console),
        editor_(sql_history_file()) {
    // The next statement may have other parameters.
    parameters_.are_all_used = false;
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
  void run(const jobs::SqlText& sql, const jobs::SqlParameters& parameters, SqlShow show) {
    jobs::run_statements(connection_, sql, parameters, printed_rows(show), console_);
  }

  void take(const std::string& line) {
    try {
      if (typed_.empty() && line.starts_with(".")) {
        command(line);
        return;
      }
      typed_ += line + "\n";
      const bool is_in_comment = sqlite3_complete((typed_ + ";").c_str()) == 0;
      if (database::TokenList(typed_).size() == 0 && !is_in_comment) typed_.clear();
      if (sqlite3_complete(typed_.c_str()) != 0)
        run({std::exchange(typed_, {}), "statement"}, parameters_, show_);
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
    using jobs::SqlForm;
    constexpr std::array<std::pair<const char*, SqlForm>, 3> k_forms = {
        {{"table", SqlForm::table}, {"csv", SqlForm::csv}, {"json", SqlForm::json}}};
    const auto form =
        std::ranges::find(k_forms, value, [](const auto& known) { return std::string(known.first); });
    if (!more.empty()) name.clear();
    if (name == ".quit" || name == ".exit") {
      is_done_ = true;
    } else if (name == ".help") {
      write_to_stdout(k_commands);
    } else if (name == ".tables") {
      run({k_tables, name}, {}, {.form = show_.form});
    } else if (name == ".schema") {
      jobs::SqlParameter table;
      if (!value.empty()) table.value = value;
      run({k_columns, name}, {.values = {table}}, {.form = show_.form});
    } else if (name == ".mode" && form != k_forms.end()) {
      show_.form = form->second;
    } else if (name == ".explain" && (value == "on" || value == "off")) {
      show_.explain = value == "on";
    } else {
      reject(line);
    }
  }

  [[noreturn]] static void reject(const std::string& line) {
    throw input_error("unknown command", "a command listed by .help", line);
  }

  const database::Connection& connection_;
  jobs::SqlParameters parameters_;
  SqlShow show_;
  Console& console_;
  LineEditor editor_;
  std::string typed_;  ///< of a statement that has not ended
  bool is_done_ = false;
};

struct SqlCommand : JobCommand<jobs::SqlRequest> {
  SqlShow show;
};

ExitCode run_sql(const SqlCommand& command) {
  const jobs::SqlPlan checked = plan(command.request);
  const jobs::CheckedSql& request = checked.request();
  Console console(command.verbosity);
  const bool is_typed = !request.source.statement && request.source.file.empty() &&
                        ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1;
  if (is_typed) {
    const auto connection = open_cloud(request, console);
    say_note(request.cloud.string() + " is open for reading; .help lists the commands");
    Prompt(*connection, request.parameters, command.show, console).run();
  } else {
    run(checked, printed_rows(command.show), console);
  }
  return ExitCode::done;
}

Command add_rewrite(const Options& sql) {
  const auto command = std::make_shared<JobCommand<jobs::RewriteRequest>>();
  const Options rewrite = sql.command(
      "rewrite", "Rewrite statements for engines without dist_ray, such as DuckDB on Parquet files");
  jobs::add_rewrite_fields(rewrite, command->request);
  add_verbosity(rewrite, command->verbosity);
  return job_command(rewrite, command, [](const auto&, const auto& statements) {
    std::string text;
    for (const database::RewrittenStatement& statement : statements) text += statement.text + ";\n";
    write_to_stdout(text);
    return ExitCode::done;
  });
}

}  // namespace

Command add_sql(const Options& program) {
  const Options sql =
      program.command("sql", "Query clouds in files or databases with SQL, and load databases");
  const auto command = std::make_shared<SqlCommand>();
  jobs::add_sql_fields(sql, command->request, [&] {
    const Field csv = sql.flag("--csv", "rows as CSV with a header",
                               [command] { command->show.form = jobs::SqlForm::csv; });
    sql.excludes(csv).flag("--json", "rows as an array of objects",
                           [command] { command->show.form = jobs::SqlForm::json; });
    sql.flag("--explain", "print what was read, the time, and how the statement was rewritten, or why not",
             command->show.explain);
  });
  add_job_options(sql, *command);
  const Run run = [command](const CommandLine& words) {
    return with_threads(command->threads, words, [&] { return run_sql(*command); });
  };
  return {sql,
          run,
          {job_command(sql.command("load", "Store a cloud in a database"), jobs::add_load_fields),
           add_rewrite(sql)}};
}

}  // namespace alidade::tools
