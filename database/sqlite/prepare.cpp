// SPDX-License-Identifier: MIT
#include "database/sqlite/prepare.h"

#include <fmt/format.h>

#include <utility>

#include "database/sqlite/prune_statement.h"
#include "database/sqlite/sql_tokens.h"
#include "octree/error.h"

namespace alidade {
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

/// Whether a statement that is being prepared reads _chunk by way of a view, whose x, y, z may be anything.
class ViewWatch {
 public:
  explicit ViewWatch(sqlite3* database) : database_(database) {
    sqlite3_set_authorizer(database, notice, this);
  }
  ~ViewWatch() { sqlite3_set_authorizer(database_, nullptr, nullptr); }
  ViewWatch(const ViewWatch&) = delete;
  ViewWatch& operator=(const ViewWatch&) = delete;

  bool has_seen_one() const { return has_seen_one_; }

 private:
  static int notice(void* self, int action, const char*, const char* column, const char*, const char* view) {
    if (action == SQLITE_READ && view != nullptr && sqlite3_stricmp(column, "_chunk") == 0)
      static_cast<ViewWatch*>(self)->has_seen_one_ = true;
    return SQLITE_OK;
  }

  sqlite3* database_;
  bool has_seen_one_ = false;
};

bool same_columns(sqlite3_stmt* a, sqlite3_stmt* b) {
  const int count = sqlite3_column_count(a);
  if (count != sqlite3_column_count(b)) return false;
  for (int i = 0; i < count; ++i) {
    if (std::string_view(sqlite3_column_name(a, i)) != sqlite3_column_name(b, i)) return false;
  }
  return true;
}

}  // namespace

Prepared prepare(sqlite3* database, std::string_view sql, std::size_t begin, const std::string& file) {
  Parsed given = parse(database, sql.substr(begin));
  if (given.result != SQLITE_OK) {
    const int byte = sqlite3_error_offset(database);
    throw Error({.file = file,
                 .place = byte < 0 ? "" : text_place(sql, begin + static_cast<std::size_t>(byte)),
                 .problem = sqlite3_errmsg(database)});
  }
  Prepared prepared{.statement = std::move(given.statement), .size = given.size};
  if (prepared.statement == nullptr) return prepared;
  PrunedStatement pruned = prune_statement(sql.substr(begin, given.size));
  prepared.reason = std::move(pruned.reason);
  if (pruned.text.empty()) return prepared;

  const ViewWatch watch(database);
  Parsed limited = parse(database, pruned.text);
  if (limited.result != SQLITE_OK) {
    prepared.reason = fmt::format("with limits it is not understood: {}", sqlite3_errmsg(database));
  } else if (watch.has_seen_one()) {
    prepared.reason = "it asks a view that has a column _chunk";
  } else if (!same_columns(prepared.statement.get(), limited.statement.get())) {
    prepared.reason = "with limits it has other columns";
  } else {
    prepared.statement = std::move(limited.statement);
    prepared.pruned = std::move(pruned.text);
  }
  return prepared;
}

}  // namespace alidade
