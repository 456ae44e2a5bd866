// SPDX-License-Identifier: MIT
// Any text as a statement: with limits beside its conditions it has the rows that it has without, and
// rewriting it gives plain SQL or an error.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "database/sql/rewrite_statement.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/functions.h"
#include "database/sqlite/prepare.h"

namespace {

/// A database in which columns _chunk are ordinary ones, so that in_chunk() is but a function.
sqlite3* open_database() {
  sqlite3* database = nullptr;
  sqlite3_open(":memory:", &database);
  alidade::database::add_functions(database);
  const auto no_chance = [](sqlite3_context* context, int, sqlite3_value**) {
    sqlite3_result_int(context, 7);
  };
  sqlite3_create_function(database, "random", 0, SQLITE_UTF8, nullptr, no_chance, nullptr, nullptr);
  sqlite3_exec(database,
               "CREATE TABLE points(id, x, y, z, _chunk); INSERT INTO points VALUES(1,0,0,0,0), (2,3,4,5,0), "
               "(3,NULL,0,1,1), (4,-2,0.5,9,1);"
               "CREATE TABLE rays(ox, oy, oz, dx, dy, dz, r); INSERT INTO rays VALUES(0,0,0,1,0,0,2), "
               "(1,2,3,0,NULL,1,1), (0,1,0,0,1,1,'a');",
               nullptr, nullptr, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, 100'000);
  return database;
}

/// All rows, sorted, and the names of columns; nothing if there is an error, or too much to do.
std::optional<std::vector<std::string>> answer(sqlite3* database, const std::string& sql) {
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v2(database, sql.c_str(), -1, &made, nullptr) != SQLITE_OK) return std::nullopt;
  const alidade::database::StatementHandle statement(made);
  if (made == nullptr || sqlite3_stmt_readonly(made) == 0 || sqlite3_stmt_isexplain(made) != 0)
    return std::nullopt;
  for (int i = 1; i <= sqlite3_bind_parameter_count(made); ++i) sqlite3_bind_double(made, i, 0.5 * i);
  int steps = 0;
  sqlite3_progress_handler(
      database, 1000, [](void* count) { return ++*static_cast<int*>(count) > 100 ? 1 : 0; }, &steps);
  std::vector<std::string> rows;
  const auto add_row = [&](auto text_of) {
    std::string row;
    for (int i = 0; i < sqlite3_column_count(made); ++i) {
      const auto* const text = reinterpret_cast<const char*>(text_of(made, i));
      row.append(text == nullptr ? "NULL" : text).append(1, '\0');
    }
    rows.push_back(row);
  };
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(made)) == SQLITE_ROW) add_row(sqlite3_column_text);
  std::ranges::sort(rows);
  add_row(sqlite3_column_name);
  if (result != SQLITE_DONE) return std::nullopt;
  return rows;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  using namespace alidade::database;
  static sqlite3* const database = open_database();
  const std::string sql(reinterpret_cast<const char*>(data), size);
  const std::string_view whole(sql.c_str());
  std::size_t end = 0;
  const TokenList tokens(whole);
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const SqlToken& token = tokens[i];
    if (token.begin < end || token.end <= token.begin || token.end > whole.size()) std::abort();
    end = token.end;
  }
  for (const SqlDialect dialect : {SqlDialect::duckdb, SqlDialect::datafusion}) {
    try {
      rewrite_statement(whole, {.dialect = dialect, .bounds = Bounds{glm::dvec3(-10.0), glm::dvec3(10.0)}});
    } catch (const Error&) {
    }
  }
  const std::string pruned = prune_statement(whole).text;
  // Which rows LIMIT leaves, and what depends on their order or on the time, is open.
  for (const char* const open :
       {"limit", "concat", "json", "now", "current", "time", "date", "over", "total", "rowid"}) {
    const std::string_view word(open);
    const auto same_letter = [](char a, char b) { return (a | 0x20) == b; };
    if (std::search(whole.begin(), whole.end(), word.begin(), word.end(), same_letter) != whole.end())
      return 0;
  }
  if (pruned.empty() || whole.find(';') != std::string_view::npos) return 0;
  const auto plain = answer(database, std::string(whole));
  const auto limited = plain ? answer(database, pruned) : std::nullopt;
  if (plain && limited && *plain != *limited) std::abort();
  return 0;
}
