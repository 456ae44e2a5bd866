// SPDX-License-Identifier: MIT
#include "database/sqlite/prepare.h"

#include <fmt/format.h>
#include <utility>

#include "base/error.h"
#include "database/sql/rewrite_statement.h"
#include "database/sql/sql_tokens.h"

namespace alidade::database {
namespace {

struct Parsed {
  StatementHandle statement;
  std::size_t size = 0;
  int result = SQLITE_OK;
};

Parsed parse(sqlite3* database, std::string_view sql) {
  sqlite3_stmt* made = nullptr;
  const char* tail = sql.data();
  const int result = sqlite3_prepare_v2(database, sql.data(), static_cast<int>(sql.size()), &made, &tail);
  return {StatementHandle(made), static_cast<std::size_t>(tail - sql.data()), result};
}

/// Watches, as SQLite's authorizer, which columns and functions a statement uses while it is prepared, also
/// through views, and finds whether limits are of use.
class UseWatch {
 public:
  explicit UseWatch(sqlite3* database) : database_(database) {
    sqlite3_set_authorizer(database, notice, this);
  }
  ~UseWatch() { sqlite3_set_authorizer(database_, nullptr, nullptr); }
  UseWatch(const UseWatch&) = delete;
  UseWatch& operator=(const UseWatch&) = delete;

  /// Why limits are of no use; empty if they are of use.
  const std::string& reason() const { return reason_; }

 private:
  static int notice(void* self, int action, const char*, const char* name, const char*, const char* view) {
    std::string& reason = static_cast<UseWatch*>(self)->reason_;
    // x, y, z of a view may be any expressions.
    if (action == SQLITE_READ && view != nullptr && sqlite3_stricmp(name, "_chunk") == 0)
      reason = "it queries a view with a column _chunk";
    // A limit would get another random number than the condition that it repeats.
    if (action == SQLITE_FUNCTION &&
        (sqlite3_stricmp(name, "random") == 0 || sqlite3_stricmp(name, "randomblob") == 0))
      reason = "it calls random or randomblob, which are volatile";
    return SQLITE_OK;
  }

  sqlite3* database_;
  std::string reason_;
};

bool same_columns(sqlite3_stmt* a, sqlite3_stmt* b) {
  const int count = sqlite3_column_count(a);
  if (count != sqlite3_column_count(b)) return false;
  for (int i = 0; i < count; ++i) {
    if (std::string_view(sqlite3_column_name(a, i)) != sqlite3_column_name(b, i)) return false;
  }
  return true;
}

/// "one of x, y, z, intensity (points); name (places)": the columns of the first few tables, for messages.
std::string columns_of_tables(sqlite3* database) {
  const Parsed query =
      parse(database,
            "SELECT group_concat(c.name, ', ') || ' (' || t.name || ')' FROM pragma_table_list t "
            "JOIN pragma_table_info(t.name, t.schema) c WHERE t.type IN ('table', 'view', 'virtual') "
            "AND t.name NOT LIKE 'sqlite!_%' ESCAPE '!' GROUP BY t.schema, t.name LIMIT 4");
  std::string text;
  while (query.statement != nullptr && sqlite3_step(query.statement.get()) == SQLITE_ROW)
    text += (text.empty() ? "one of " : "; ") +
            std::string(reinterpret_cast<const char*>(sqlite3_column_text(query.statement.get(), 0)));
  return text;
}

}  // namespace

Prepared prepare(sqlite3* database, std::string_view sql, std::size_t begin, const std::string& file) {
  Parsed given = parse(database, sql.substr(begin));
  if (given.result != SQLITE_OK) {
    const int byte = sqlite3_error_offset(database);
    std::string problem = sqlite3_errmsg(database);
    std::string expected = problem.starts_with("no such column") ? columns_of_tables(database) : "";
    throw Error({.file = file,
                 .location = byte < 0 ? "" : text_location(sql, begin + static_cast<std::size_t>(byte)),
                 .problem = std::move(problem),
                 .expected = std::move(expected)});
  }
  Prepared prepared{.statement = std::move(given.statement), .size = given.size};
  if (prepared.statement == nullptr) return prepared;
  PrunedStatement pruned = prune_statement(sql.substr(begin, given.size));
  prepared.reason = std::move(pruned.reason);
  if (pruned.text.empty()) return prepared;

  const UseWatch watch(database);
  Parsed limited = parse(database, pruned.text);
  if (limited.result != SQLITE_OK) {
    prepared.reason = fmt::format("with limits it cannot be parsed: {}", sqlite3_errmsg(database));
  } else if (!watch.reason().empty()) {
    prepared.reason = watch.reason();
  } else if (!same_columns(prepared.statement.get(), limited.statement.get())) {
    prepared.reason = "with limits it has other columns";
  } else {
    prepared.statement = std::move(limited.statement);
    prepared.pruned = std::move(pruned.text);
  }
  return prepared;
}

}  // namespace alidade::database
