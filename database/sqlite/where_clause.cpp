// SPDX-License-Identifier: MIT
#include "database/sqlite/where_clause.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <iterator>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/words.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/virtual_table.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

/// Rows that one connection evaluates: opening it takes as long as a few hundred of them.
constexpr std::size_t k_rows_at_once = 1 << 16;

constexpr const char* k_example = R"(a condition such as "classification = 2 AND intensity > 100")";

/// The rows [first, end) of a cloud as a table that SQLite reads.
struct Rows {
  const PointColumns& cloud;
  const std::vector<CloudColumn>& columns;
  std::size_t first, end;
};

/// A name for the hidden column with the number of a row that no attribute has.
std::string row_column(const std::vector<CloudColumn>& columns) {
  std::string name = "_row";
  const auto is_name = [&](const CloudColumn& column) { return lower_case(column.like.name) == name; };
  while (std::ranges::any_of(columns, is_name)) name += '_';
  return name;
}

struct RowTable {
  sqlite3_vtab base{};  // SQLite's part, which must be first
  const Rows& rows;

  int best_index(sqlite3_index_info& info) const {
    info.estimatedRows = static_cast<sqlite3_int64>(rows.end - rows.first);
    info.estimatedCost = static_cast<double>(info.estimatedRows);
    return SQLITE_OK;
  }
};

struct RowCursor {
  sqlite3_vtab_cursor base{};  // SQLite's part, which must be first
  const Rows& rows;
  std::size_t row = 0;

  explicit RowCursor(const RowTable& table) : rows(table.rows) {}

  void filter(int, const char*, std::span<sqlite3_value* const>) { row = rows.first; }
  void next() { ++row; }
  bool at_end() const noexcept { return row >= rows.end; }

  void column(sqlite3_context* context, int number) const {
    const auto column = static_cast<std::size_t>(number);
    if (column == rows.columns.size())
      sqlite3_result_int64(context, static_cast<sqlite3_int64>(row));
    else
      set_result(context, value_of(rows.cloud, rows.columns[column], row));
  }
};

int connect_rows(sqlite3* database, void* rows, int, const char* const*, sqlite3_vtab** made,
                 char** message) {
  return guarded(
      [&] {
        std::unique_ptr<RowTable> table(new RowTable{.rows = *static_cast<const Rows*>(rows)});
        std::vector<std::string> names;
        for (const CloudColumn& column : table->rows.columns) names.push_back(sql_name(column.like.name));
        // WITHOUT ROWID, since in a condition rowid would be the number of a row within its block.
        const std::string row = row_column(table->rows.columns);
        const int result = sqlite3_declare_vtab(
            database, fmt::format("CREATE TABLE point({},{} INTEGER HIDDEN, PRIMARY KEY({})) WITHOUT ROWID",
                                  fmt::join(names, ","), row, row)
                          .c_str());
        if (result == SQLITE_OK) *made = &table.release()->base;
        return result;
      },
      [&](const char* text) { keep_message(message, text); });
}

/// A module without xCreate has a table of its name, which exists without CREATE VIRTUAL TABLE.
const sqlite3_module k_row_module = [] {
  sqlite3_module module = reading_module<RowTable, RowCursor>();
  module.xConnect = connect_rows;
  return module;
}();

/// A connection to a database in memory without tables, or with a table of some rows.
class Evaluation {
 public:
  explicit Evaluation(const Rows* rows, const std::function<bool()>* is_given_up = nullptr) {
    const int result =
        sqlite3_open_v2(":memory:", &database_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY, nullptr);
    // Otherwise a name in double quotes that is not a column would be a text.
    sqlite3_db_config(database_, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
    if (result != SQLITE_OK || add_functions(database_) != SQLITE_OK ||
        (rows != nullptr && sqlite3_create_module_v2(database_, "point", &k_row_module,
                                                     const_cast<Rows*>(rows), nullptr) != SQLITE_OK)) {
      const std::string message = sqlite3_errmsg(database_);
      sqlite3_close(database_);
      throw Error({.problem = message});
    }
    constexpr int k_steps = 1000;
    if (is_given_up != nullptr && *is_given_up)
      sqlite3_progress_handler(database_, k_steps, stops, const_cast<std::function<bool()>*>(is_given_up));
  }
  ~Evaluation() { sqlite3_close(database_); }
  Evaluation(const Evaluation&) = delete;
  Evaluation& operator=(const Evaluation&) = delete;

  sqlite3* get() const { return database_; }

 private:
  static int stops(void* is_given_up) {
    return (*static_cast<const std::function<bool()>*>(is_given_up))() ? 1 : 0;
  }

  sqlite3* database_ = nullptr;
};

[[noreturn]] void reject(const std::string& text, std::string_view message, std::string expected) {
  throw Error(
      {.problem = fmt::format("invalid condition '{}': {}", text, message), .expected = std::move(expected)});
}

/// Errors: the text has a parameter, or its value may differ next time: it depends on a random number, the
/// clock, the time zone of the machine, or earlier statements.
void reject_changing(const std::string& text) {
  constexpr const char* k_remedy =
      "a condition on values of the points, which always holds for the same ones "
      "(to thin a cloud: 'alidade convert --every N')";
  constexpr std::string_view k_changing[] = {"random", "randomblob", "changes", "total_changes",
                                             "last_insert_rowid"};
  constexpr std::string_view k_dates[] = {"date",      "time",     "datetime", "julianday",
                                          "unixepoch", "strftime", "timediff"};
  // "subsec" instead of a time is the current time.
  constexpr std::string_view k_variable[] = {"'now'", "'subsec'", "'subsecond'", "'localtime'", "'utc'"};
  const TokenList tokens(text);
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string word(tokens.text(i));
    if (tokens.is(i, SqlTokenKind::parameter))
      reject(text, fmt::format("it has the parameter {}", word), "a value in its place");
    const bool is_clock = tokens.is_one_of(i, {"current_date", "current_time", "current_timestamp"});
    const bool is_call = tokens.is_name(i) && tokens.is_sign(i + 1, "(");
    const auto calls_one_of = [&](std::span<const std::string_view> names) {
      return is_call && std::ranges::find(names, plain_name(word)) != names.end();
    };
    if (is_clock || calls_one_of(k_changing))
      reject(text, word + " changes from one time to the next", k_remedy);
    if (!calls_one_of(k_dates) || !tokens.is_sound()) continue;
    // Without a time these use the current one.
    const std::vector<TokenRange> arguments = tokens.arguments(i + 1);
    const std::size_t least = plain_name(word) == "strftime" ? 2 : 1;
    const std::size_t closing = tokens.closing(i + 1);
    bool is_fixed = closing > i + 2 && arguments.size() >= least;
    for (std::size_t j = i + 2; j < closing; ++j)
      is_fixed =
          is_fixed && std::ranges::find(k_variable, lower_case(tokens.text(j))) == std::end(k_variable);
    if (!is_fixed)
      reject(text, word + " of the present, or of the time zone here, changes from one time to the next",
             k_remedy);
  }
}

}  // namespace

WhereClause::WhereClause(std::string text) : text_(std::move(text)) {
  reject_changing(text_);
  const Evaluation evaluation(nullptr);
  // A parenthesis in the text must not close the one around the text.
  const std::string alone = "SELECT 1 WHERE " + text_;
  sqlite3_stmt* statement = nullptr;
  const char* tail = nullptr;
  const int result = sqlite3_prepare_v2(evaluation.get(), alone.c_str(), -1, &statement, &tail);
  sqlite3_finalize(statement);
  const std::string message = sqlite3_errmsg(evaluation.get());
  if (result != SQLITE_OK && !message.starts_with("no such column")) reject(text_, message, k_example);
  if (text_.find_first_not_of(" \t\n") == std::string::npos || text_.find(';') != std::string::npos)
    reject(text_, text_.find(';') == std::string::npos ? "it is empty" : "';' ends it", k_example);
}

void WhereClause::mark(const PointCloud& cloud, std::span<std::uint8_t> marks,
                       const std::function<bool()>& is_given_up) const {
  const PointColumns points = points_of(cloud);
  const std::vector<CloudColumn> columns = cloud_columns(points);
  in_blocks(cloud.size(), k_rows_at_once, [&](std::size_t first, std::size_t end) {
    const Rows rows{points, columns, first, end};
    std::fill(marks.begin() + static_cast<std::ptrdiff_t>(rows.first),
              marks.begin() + static_cast<std::ptrdiff_t>(rows.end), std::uint8_t{0});
    const Evaluation evaluation(&rows, &is_given_up);
    try {
      Statement statement(evaluation.get(),
                          "SELECT " + row_column(columns) + " FROM point WHERE (" + text_ + "\n)");
      while (statement.step()) marks[static_cast<std::size_t>(statement.whole(0))] = 1;
    } catch (const Error& error) {
      if (is_given_up && is_given_up()) throw Cancelled();
      std::vector<std::string_view> names;
      for (const CloudColumn& column : columns) names.push_back(column.like.name);
      reject(text_, error.parts().problem, fmt::format("a condition on {}", fmt::join(names, ", ")));
    }
  });
}

}  // namespace alidade::database
