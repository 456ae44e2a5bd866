// SPDX-License-Identifier: MIT
#include "database/sqlite/prepare.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "base/error.h"
#include "database/sqlite/distance_condition.h"
#include "database/sqlite/sql_tokens.h"

namespace alidade::database {
namespace {

/// Why a statement is not changed, whatever its conditions are; empty if it may be changed.
std::string reason_to_leave(const TokenList& tokens) {
  if (!tokens.is_sound()) return "it cannot be parsed";
  std::size_t first = 0;
  if (tokens.is_word(0, "explain")) first = tokens.is_word(1, "query") ? 3 : 1;
  if (tokens.is_word(first, "with")) return "it has a WITH clause";
  if (!tokens.is_word(first, "select")) return "it is not a SELECT";
  bool has_distance = false, has_plain = false, has_named = false;
  for (std::size_t i = first + 1; i < tokens.size(); ++i) {
    if (tokens.is_word(i, "select")) return "it has more than one SELECT";
    if (tokens.is_word(i, "values")) return "it has VALUES";
    if (tokens.is_one_of(i, {"natural", "using", "right", "full"}))
      return "it has a NATURAL, USING, RIGHT or FULL join";
    if (tokens.is(i, SqlTokenKind::parameter)) (tokens.text(i) == "?" ? has_plain : has_named) = true;
    has_distance = has_distance || is_distance(tokens, i);
  }
  if (!has_distance) return "it has no condition on dist_ray or dist_plane";
  if (has_plain && has_named) return "only some of its parameters are plain question marks";
  return {};
}

/// The join to which an ON belongs.
struct Join {
  bool is_left = false;
  std::string table;  ///< name of the joined table as written; empty if unclear
};

class Pruner {
 public:
  explicit Pruner(std::string_view sql) : sql_(sql), tokens_(sql) {}

  PrunedStatement prune() {
    reason_ = reason_to_leave(tokens_);
    if (!reason_.empty()) return {.text = {}, .reason = reason_};
    copy_tokens();
    read_clauses();
    if (!has_limits_) note("dist_ray or dist_plane is not in a condition of WHERE or ON");
    return {.text = has_limits_ ? text() : std::string(), .reason = reason_};
  }

 private:
  /// Copies the tokens; plain parameters get numbers.
  void copy_tokens() {
    int count = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      texts_.emplace_back(tokens_.text(i));
      if (tokens_.is(i, SqlTokenKind::parameter) && texts_[i] == "?") texts_[i] += std::to_string(++count);
    }
  }

  std::string range_text(TokenRange range) const {
    std::string text;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      // Comments and line breaks between tokens become a blank.
      if (i > range.begin && tokens_[i].begin > tokens_[i - 1].end) text += ' ';
      text += texts_[i];
    }
    return text;
  }

  /// Finds ON and WHERE outside parentheses.
  void read_clauses() {
    Join join;
    for (std::size_t i = 0; i < tokens_.size();) {
      if (tokens_.is_word(i, "join")) join = read_join(i);
      if (tokens_.is_sign(i, "("))
        i = tokens_.closing(i) + 1;
      else if (tokens_.is_one_of(i, {"on", "where"}))
        i = conditions(i + 1, tokens_.is_word(i, "on") ? join : Join{}, 0);
      else
        ++i;
    }
  }

  Join read_join(std::size_t token) const {
    Join join;
    join.is_left = token > 0 && tokens_.is_one_of(token - 1, {"left", "outer"});
    std::size_t i = token + 1;
    if (!tokens_.is_name(i)) return join;
    while (tokens_.is_sign(i + 1, ".") && tokens_.is_name(i + 2)) i += 2;
    join.table = tokens_.text(i++);
    if (tokens_.is_sign(i, "(")) i = tokens_.closing(i) + 1;
    if (tokens_.is_word(i, "as")) ++i;
    if (tokens_.is_name(i) && !tokens_.is_one_of(i, {"on", "indexed", "not"})) join.table = tokens_.text(i);
    return join;
  }

  /// Reads conditions between AND and OR. Returns the index of the token after them.
  std::size_t conditions(std::size_t i, const Join& join, int depth) {
    i = condition(i, join, depth);
    while (tokens_.is_one_of(i, {"and", "or"})) i = condition(i + 1, join, depth);
    return i;
  }

  std::size_t condition(std::size_t i, const Join& join, int depth) {
    while (tokens_.is_word(i, "not")) ++i;
    if (tokens_.is_sign(i, "(") && ends_condition(tokens_, tokens_.closing(i) + 1)) {
      const std::size_t closing = tokens_.closing(i);
      if (depth < k_deepest_parentheses)
        conditions(i + 1, join, depth + 1);
      else
        note("it has too many parentheses");
      return closing + 1;
    }
    ConditionAnswer answer = read_condition(tokens_, i);
    if (answer.condition) {
      add_limit(*answer.condition, join);
      return answer.condition->tokens.end;
    }
    note(answer.reason);
    const std::size_t end = end_of_condition(tokens_, i);
    for (; i < end; ++i) {
      if (is_distance(tokens_, i)) note("a distance is part of a larger expression");
    }
    return end;
  }

  void add_limit(const DistanceCondition& condition, const Join& join) {
    std::string table = range_text(condition.table);
    if (join.is_left) {
      // A limit must not remove rows of the table whose rows a LEFT JOIN keeps.
      const bool is_joined = condition.table.begin == condition.table.end ||
                             (condition.table.end - condition.table.begin == 2 &&
                              plain_name(tokens_.text(condition.table.begin)) == plain_name(join.table));
      if (join.table.empty() || !is_joined) {
        note("a condition in ON of LEFT JOIN is not on the joined table");
        return;
      }
      table = std::string(join.table).append(".");
    }
    const bool is_ray = condition.function == "dist_ray";
    std::string limit = " AND in_chunk(";
    limit.append(table).append("_chunk, ").append(is_ray ? "try_ray_limit(" : "try_plane_limit(");
    for (const TokenRange& number : condition.ray) limit += range_text(number) + ", ";
    // 1e999 is SQL for infinity; no distance to a ray is below 0.
    limit += condition.least ? range_text(*condition.least) : is_ray ? "0" : "-1e999";
    limit += ", " + (condition.largest ? range_text(*condition.largest) : "1e999") + "))";
    std::string& first = texts_[condition.tokens.begin];
    first = std::string("(").append(first);
    texts_[condition.tokens.end - 1] += limit + ")";
    has_limits_ = true;
  }

  void note(const std::string& reason) {
    if (reason_.empty()) reason_ = reason;
  }

  std::string text() const {
    std::string text;
    std::size_t end = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      text += sql_.substr(end, tokens_[i].begin - end);
      text += texts_[i];
      end = tokens_[i].end;
    }
    return text.append(sql_.substr(end));
  }

  std::string_view sql_;
  TokenList tokens_;
  std::vector<std::string> texts_;  ///< of the tokens, with what is added before and after them
  bool has_limits_ = false;
  std::string reason_;
};

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

PrunedStatement prune_statement(std::string_view sql) {
  return Pruner(sql).prune();
}

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
