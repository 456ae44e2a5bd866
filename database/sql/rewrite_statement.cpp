// SPDX-License-Identifier: MIT
#include "database/sql/rewrite_statement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "database/box_cover.h"
#include "database/point_filter.h"
#include "database/sql/conditions.h"
#include "database/sql/sql_tokens.h"

namespace alidade::database {
namespace {

/// A table of FROM or JOIN: a name, a file's name or a function that reads one.
struct TableReference {
  TokenRange tokens{};          ///< without its alias
  std::string name{}, alias{};  ///< as written; no name for a file's name
  std::size_t end = 0;          ///< the token after it
};

/// Reads the table at a token; empty if there is something else.
std::optional<TableReference> read_table(const TokenList& tokens, std::size_t i) {
  TableReference table{.tokens = {i, i}};
  if (tokens.is_name(i)) {
    while (tokens.is_sign(i + 1, ".") && tokens.is_name(i + 2)) i += 2;
    table.name = tokens.text(i);
  } else if (!tokens.is(i, SqlTokenKind::text)) {
    return std::nullopt;
  }
  ++i;
  if (tokens.is_sign(i, "(")) i = tokens.closing(i) + 1;
  table.tokens.end = i;
  if (tokens.is_word(i, "as")) ++i;
  if (tokens.is_name(i) && !tokens.is_one_of(i, {"on", "where", "indexed", "not"}))
    table.alias = tokens.text(i++);
  table.end = i;
  return table;
}

/// A statement while it is rewritten.
class EditedStatement {
 protected:
  /// What becomes of a token.
  struct Edit {
    std::string text;
    std::string behind{};     ///< what is added after it
    bool is_dropped = false;  ///< leaves the token out, and what is before it
  };

  EditedStatement(std::string_view sql, std::string_view foreign_signs)
      : sql_(sql), tokens_(sql, foreign_signs) {
    for (std::size_t i = 0; i < tokens_.size(); ++i) edits_.push_back({std::string(tokens_.text(i))});
  }

  /// The first reason is the one that is told.
  void note(std::string reason) {
    if (reason_.empty()) reason_ = std::move(reason);
  }

  bool has_distance(TokenRange range) const {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      if (is_distance(tokens_, i)) return true;
    }
    return false;
  }

  std::string text() const {
    std::string text;
    std::size_t end = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      const Edit& edit = edits_[i];
      if (!edit.is_dropped) text.append(sql_.substr(end, tokens_[i].begin - end)).append(edit.text);
      text += edit.behind;
      end = tokens_[i].end;
    }
    return text.append(sql_.substr(end));
  }

  std::string_view sql_;
  TokenList tokens_;
  std::vector<Edit> edits_;
  std::string reason_;
};

/// The join to which an ON belongs.
struct Join {
  bool is_left = false;
  std::string table{};  ///< name of the joined table as written; empty if unclear
};

class Pruner : EditedStatement {
 public:
  explicit Pruner(std::string_view sql) : EditedStatement(sql, {}) {}

  PrunedStatement prune() {
    reason_ = reason_to_leave();
    if (!reason_.empty()) return {.text = {}, .reason = reason_};
    number_parameters();
    read_clauses();
    if (!has_limits_) note("dist_ray or dist_plane is not in a condition of WHERE or ON");
    return {.text = has_limits_ ? text() : std::string(), .reason = reason_};
  }

 private:
  /// Why the statement is not changed, whatever its conditions are; empty if it may be changed.
  std::string reason_to_leave() const {
    if (!tokens_.is_sound()) return "it cannot be parsed";
    std::size_t first = 0;
    if (tokens_.is_word(0, "explain")) first = tokens_.is_word(1, "query") ? 3 : 1;
    if (tokens_.is_word(first, "with")) return "it has a WITH clause";
    if (!tokens_.is_word(first, "select")) return "it is not a SELECT";
    bool has_plain = false, has_named = false;
    for (std::size_t i = first + 1; i < tokens_.size(); ++i) {
      if (tokens_.is_word(i, "select")) return "it has more than one SELECT";
      if (tokens_.is_word(i, "values")) return "it has VALUES";
      if (tokens_.is_one_of(i, {"natural", "using", "right", "full"}))
        return "it has a NATURAL, USING, RIGHT or FULL join";
      if (tokens_.is(i, SqlTokenKind::parameter)) (tokens_.text(i) == "?" ? has_plain : has_named) = true;
    }
    if (!has_distance({first, tokens_.size()})) return "it has no condition on dist_ray or dist_plane";
    if (has_plain && has_named) return "only some of its parameters are plain question marks";
    return {};
  }

  void number_parameters() {
    int count = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      if (tokens_.is(i, SqlTokenKind::parameter) && tokens_.text(i) == "?")
        edits_[i].text += std::to_string(++count);
    }
  }

  /// The tokens, numbered parameters among them; comments and line breaks between them become a blank.
  std::string range_text(TokenRange range) const {
    std::string text;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      if (i > range.begin && tokens_[i].begin > tokens_[i - 1].end) text += ' ';
      text += edits_[i].text;
    }
    return text;
  }

  /// Finds ON and WHERE outside parentheses.
  void read_clauses() {
    Join join;
    for (std::size_t i = 0; i < tokens_.size();) {
      if (tokens_.is_word(i, "join")) {
        join = {.is_left = i > 0 && tokens_.is_one_of(i - 1, {"left", "outer"})};
        if (const std::optional<TableReference> table = read_table(tokens_, i + 1))
          join.table = table->alias.empty() ? table->name : table->alias;
      }
      if (tokens_.is_sign(i, "(")) {
        i = tokens_.closing(i) + 1;
      } else if (tokens_.is_one_of(i, {"on", "where"})) {
        const Condition condition = read_conditions(tokens_, i + 1);
        add_limits(condition, tokens_.is_word(i, "on") ? join : Join{});
        i = condition.tokens.end;
      } else {
        ++i;
      }
    }
  }

  void add_limits(const Condition& condition, const Join& join) {
    for (const Condition& part : condition.parts) add_limits(part, join);
    if (condition.kind == Condition::Kind::distance) add_limit(condition, join);
    if (condition.kind != Condition::Kind::other) return;
    note(condition.reason);
    if (has_distance(condition.tokens)) note("a distance is part of a larger expression");
  }

  void add_limit(const Condition& condition, const Join& join) {
    const DistanceCall& call = condition.call;
    std::string table = range_text(call.table);
    if (join.is_left) {
      // A limit must not remove rows of the table whose rows a LEFT JOIN keeps.
      const bool is_joined =
          call.table.empty() || (call.table.end - call.table.begin == 2 &&
                                 plain_name(tokens_.text(call.table.begin)) == plain_name(join.table));
      if (join.table.empty() || !is_joined)
        return note("a condition in ON of LEFT JOIN is not on the joined table");
      table = join.table + ".";
    }
    std::string limit = fmt::format(" AND in_chunk({}_chunk, try_{}_limit(", table,
                                    call.kind == DistanceKind::ray ? "ray" : "plane");
    for (const TokenRange& number : call.line) limit += range_text(number) + ", ";
    // 1e999 is SQL for infinity; no distance to a ray is below 0.
    limit += condition.least ? range_text(*condition.least) : call.kind == DistanceKind::ray ? "0" : "-1e999";
    limit += ", " + (condition.largest ? range_text(*condition.largest) : "1e999") + "))";
    std::string& first = edits_[condition.comparison.begin].text;
    first.insert(0, 1, '(');
    edits_[condition.comparison.end - 1].behind = limit + ")";
    has_limits_ = true;
  }

  bool has_limits_ = false;
};

// The parts of SQL that all engines parse as SQLite does.

/// Characters of operators in other dialects that SQLite does not have: casts, structs, powers.
constexpr std::string_view k_foreign_signs = ":{}^#!@";

/// Why other engines may cut a statement into other tokens than SQLite does, so that a condition may be part
/// of a text or comment; empty if they do not.
std::string foreign_tokens(std::string_view sql, const TokenList& tokens) {
  if (std::ranges::count(sql, '$') > 1) return "text between dollar signs";
  std::size_t end = 0;
  for (std::size_t i = 0; i <= tokens.size(); ++i) {
    const std::string_view between =
        sql.substr(end, (i < tokens.size() ? tokens[i].begin : sql.size()) - end);
    const std::size_t comment = between.find("/*");
    if (comment != std::string_view::npos && between.find("/*", comment + 2) != std::string_view::npos)
      return "a comment within or behind a comment";
    if (i == tokens.size()) break;
    const std::string_view text = tokens.text(i);
    if (tokens.is(i, SqlTokenKind::text) && text.find('\\') != std::string_view::npos)
      return "a backslash in a text";
    if (text.front() == '[' && std::ranges::count(text, '\'') % 2 != 0)
      return "a bracket in a text of a list";
    end = tokens[i].end;
  }
  return {};
}

/// The value of a number with signs and parentheses; empty for other expressions, which engines evaluate
/// differently.
std::optional<double> constant(const TokenList& tokens, TokenRange range) {
  double sign = 1.0;
  while (range.begin + 1 < range.end) {
    if (tokens.is_sign(range.begin, "(") && tokens.closing(range.begin) == range.end - 1)
      --range.end;
    else if (tokens.is_sign(range.begin, "-"))
      sign = -sign;
    else if (!tokens.is_sign(range.begin, "+"))
      return std::nullopt;
    ++range.begin;
  }
  if (range.begin + 1 != range.end || !tokens.is(range.begin, SqlTokenKind::number)) return std::nullopt;
  const std::string_view text = tokens.text(range.begin);
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return sign * number;
}

/// The shortest digits that are read as the same number, with an exponent: without one, several engines read
/// a literal as a decimal number.
std::string literal(double number) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::scientific).ptr;
  return {text.data(), end};
}

/// "(name - origin) * factor"; empty if the factor is 0.
std::string product(const std::string& name, double origin, double factor) {
  if (factor == 0.0) return {};
  const std::string difference =
      origin == 0.0 ? name
                    : fmt::format("({} {} {})", name, origin < 0.0 ? '+' : '-', literal(std::fabs(origin)));
  return fmt::format("{} * {}", difference, literal(factor));
}

/// dist_ray or dist_plane (octree/distance.h: project() and signed_distance()) in the same order of
/// operations, of the columns of these names. Lengths in the unit of the coordinates. Products with 0 are
/// omitted: they do not change sums of finite numbers.
std::string distance_expression(DistanceKind kind, const std::array<std::string, 3>& coordinates,
                                const CloudLine& line) {
  const bool is_ray = kind == DistanceKind::ray;
  const glm::dvec3 &origin = line.position, &direction = line.unit;
  const auto term = [&](int axis, double factor) {
    return product(coordinates[static_cast<std::size_t>(axis)], origin[axis], factor);
  };
  std::vector<std::string> terms;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    if (!is_ray) {
      terms.push_back(term(axis, direction[axis]));
      continue;
    }
    const std::string left = term(next, direction[last]), right = term(last, direction[next]);
    const std::string cross =
        left.empty() || right.empty() ? left + right : fmt::format("{} - {}", left, right);
    terms.push_back(cross.empty() ? "" : fmt::format("({0}) * ({0})", cross));
  }
  std::erase(terms, "");
  return fmt::format("{}({})", is_ray ? "sqrt" : "", fmt::join(terms, " + "));
}

using MayHold = std::function<bool(const Bounds&)>;

class Rewriter : EditedStatement {
 public:
  Rewriter(std::string_view sql, const RewriteOptions& options)
      : EditedStatement(sql, k_foreign_signs), options_(options) {
    if (!tokens_.is_sound()) {
      throw Error({.file = "statement",
                   .problem = "it cannot be parsed",
                   .expected = "whole literals and a closing parenthesis for every opening one"});
    }
    if (std::string foreign = foreign_tokens(sql, tokens_); !foreign.empty()) {
      throw Error({.file = "statement",
                   .problem = "engines may read it differently",
                   .expected = "a statement without backslashes in texts, dollar quotes and nested comments",
                   .found = std::move(foreign)});
    }
  }

  RewrittenStatement rewrite() {
    replace_distances();
    if (reason_ = reason_to_leave(); reason_.empty()) add_boxes();
    return {.text = text(), .reason = reason_, .box_count = box_count_, .share = share_};
  }

 private:
  std::string source(TokenRange range) const {
    return std::string(
        sql_.substr(tokens_[range.begin].begin, tokens_[range.end - 1].end - tokens_[range.begin].begin));
  }

  [[noreturn]] void reject(std::size_t token, std::string problem, std::string expected,
                           std::string found = {}) const {
    throw Error({.file = "statement",
                 .location = text_location(sql_, tokens_[token].begin),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  }

  CloudLine line_of(const DistanceCall& call) const {
    std::array<glm::dvec3, 2> line{};
    for (std::size_t i = 0; i < call.line.size(); ++i) {
      const std::optional<double> value = constant(tokens_, call.line[i]);
      if (!value)
        reject(call.line[i].begin, fmt::format("argument {} of {} is not constant", i + 1, call.function),
               "a number (other engines get the numbers of a ray, not its columns)", source(call.line[i]));
      line[i / 3][static_cast<int>(i % 3)] = *value;
    }
    return make_line(call.kind, line[0], line[1]);
  }

  /// The columns x, y, z as written, since other engines distinguish upper and lower case in quoted names.
  std::array<std::string, 3> coordinates_of(const DistanceCall& call) const {
    std::array<std::string, 3> names;
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
      const std::size_t last = call.coordinates[axis].end - 1;
      if (tokens_.is(last, SqlTokenKind::quoted_name) && tokens_.text(last)[1] != "xyz"[axis])
        reject(last, "a quoted coordinate has capitals", "x, y, z", std::string(tokens_.text(last)));
      names[axis] = source(call.coordinates[axis]);
    }
    return names;
  }

  void replace_distances() {
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      if (!is_distance(tokens_, i)) continue;
      DistanceCall call;
      if (std::string reason = read_call(tokens_, i, call); !reason.empty())
        reject(i, std::move(reason),
               "dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) or dist_plane(px,py,pz, nx,ny,nz, x,y,z)");
      const std::size_t end = tokens_.closing(i + 1);
      const bool is_plane = call.kind == DistanceKind::plane;
      std::string& text = edits_[i].text =
          distance_expression(call.kind, coordinates_of(call), line_of(call));
      // Arrow's comparisons put -0 before 0.
      if (is_plane && options_.dialect == SqlDialect::datafusion) text.insert(text.size() - 1, " + 0e+00");
      drop(i + 1, end + 1);
      i = end;
    }
  }

  /// Why a statement is not changed; empty if it may be. Finds the table and the condition.
  std::string reason_to_leave() {
    if (!options_.bounds || options_.bounds->empty()) return "the bounds of the points are not given";
    std::size_t first = tokens_.is_word(0, "explain") ? 1 : 0;
    if (first == 1 && tokens_.is_word(1, "analyze")) first = 2;
    if (!tokens_.is_word(first, "select")) return "it is not a SELECT";
    std::size_t from = tokens_.size();
    for (std::size_t i = first + 1; i < tokens_.size(); ++i) {
      if (tokens_.is_word(i, "select") || tokens_.is_word(i, "values")) return "it has more than one SELECT";
    }
    for (std::size_t i = first + 1; i < tokens_.size() && from == tokens_.size(); ++i) {
      if (tokens_.is_sign(i, "(")) i = tokens_.closing(i);
      if (tokens_.is_word(i, "from")) from = i;
    }
    const std::optional<TableReference> table = read_table(tokens_, from + 1);
    if (!table || !tokens_.is_word(table->end, "where"))
      return "it is not SELECT ... FROM one table WHERE ...";
    table_ = *table;
    condition_.begin = table_.end + 1;
    condition_.end = condition_.begin;
    while (condition_.end < tokens_.size() && !tokens_.is_sign(condition_.end, ";") &&
           !tokens_.is_one_of(
               condition_.end,
               {"group", "having", "window", "order", "limit", "offset", "fetch", "qualify", "for", "union",
                "intersect", "except", "minus", "using", "sort", "cluster", "distribute", "lateral"})) {
      condition_.end =
          tokens_.is_sign(condition_.end, "(") ? tokens_.closing(condition_.end) + 1 : condition_.end + 1;
    }
    return condition_.empty() ? "its condition is empty" : "";
  }

  /// Whether the condition may hold in a box, and what of it prunes nothing. Empty: no box can be left out.
  MayHold may_hold_of(const Condition& condition) {
    using Kind = Condition::Kind;
    if (condition.is_negated || condition.kind == Kind::other) {
      if (!condition.is_negated) note(condition.reason);
      if (has_distance(condition.tokens)) note("a distance is part of a larger expression or below NOT");
      return {};
    }
    if (!condition.is_whole) return {};
    if (condition.kind == Kind::distance) return limit_of(condition);
    const bool is_any = condition.kind == Kind::any;
    std::vector<MayHold> parts;
    for (const Condition& part : condition.parts) parts.push_back(may_hold_of(part));
    const auto prunes_nothing = [](const MayHold& part) { return !part; };
    if (is_any && std::ranges::any_of(parts, prunes_nothing)) return {};
    std::erase_if(parts, prunes_nothing);
    if (parts.size() <= 1) return parts.empty() ? MayHold() : parts.front();
    return [is_any, parts = std::move(parts)](const Bounds& box) {
      const auto holds = [&](const MayHold& part) { return part(box); };
      return is_any ? std::ranges::any_of(parts, holds) : std::ranges::all_of(parts, holds);
    };
  }

  std::optional<double> limit_value(const std::optional<TokenRange>& limit, double otherwise) {
    if (!limit) return otherwise;
    const std::optional<double> value = constant(tokens_, *limit);
    if (value) {
      edits_[limit->begin].text = literal(*value);
      drop(limit->begin + 1, limit->end);
    }
    return value;
  }

  MayHold limit_of(const Condition& condition) {
    constexpr double k_infinite = std::numeric_limits<double>::infinity();
    const bool is_ray = condition.call.kind == DistanceKind::ray;
    const std::optional<double> low = limit_value(condition.least, is_ray ? 0.0 : -k_infinite);
    const std::optional<double> high = limit_value(condition.largest, k_infinite);
    if (!low || !high) {
      note("a limit on a distance is not constant");
      return {};
    }
    PointFilter filter;
    filter.add(condition.call.kind, line_of(condition.call), {*low, *high});
    return [filter = std::move(filter)](const Bounds& box) { return may_hold(filter, box); };
  }

  /// The condition on x, y and z of a box; points on a face that two boxes share belong to the latter.
  std::string box_condition(const BoxCover& cover, std::size_t number) const {
    const Bounds& box = cover.boxes[number];
    const Bounds& bounds = *options_.bounds;
    std::vector<std::string> parts;
    for (int axis = 0; axis < 3; ++axis) {
      const char name = "xyz"[axis];
      if (box.min[axis] > bounds.min[axis])
        parts.push_back(fmt::format("{} >= {}", name, literal(box.min[axis])));
      if (box.max[axis] >= bounds.max[axis]) continue;
      const bool is_shared = axis == cover.axis && number + 1 < cover.boxes.size() &&
                             cover.boxes[number + 1].min[axis] == box.max[axis];
      parts.push_back(fmt::format("{} {} {}", name, is_shared ? "<" : "<=", literal(box.max[axis])));
    }
    return parts.empty() ? "1 = 1" : fmt::format("{}", fmt::join(parts, " AND "));
  }

  void add_boxes() {
    const Condition condition = read_conditions(tokens_, condition_.begin);
    const MayHold may_hold = may_hold_of(condition);
    if (condition.tokens.end != condition_.end) return note("its condition cannot be parsed");
    if (!may_hold)
      return note("its condition prunes nothing: dist_ray or dist_plane must be compared with a constant");
    const BoxCover boxes = cover(may_hold, *options_.bounds, options_.box_count);
    std::vector<std::string> conditions;
    share_ = 0.0;
    for (std::size_t i = 0; i < boxes.boxes.size(); ++i) {
      conditions.push_back(box_condition(boxes, i));
      share_ += volume_share(boxes.boxes[i], *options_.bounds);
    }
    // Conditions on nearly all of the bounds are of no use.
    constexpr double k_nearly_all = 0.999;
    if (share_ > k_nearly_all) return note("its condition may hold anywhere within the bounds");
    box_count_ = conditions.size();
    const bool is_union = options_.dialect == SqlDialect::duckdb || options_.dialect == SqlDialect::trino;
    if (box_count_ > 1 && is_union) {
      scan_each(conditions);
      return;
    }
    std::string& first = edits_[condition_.begin].text;
    const std::string sum = box_count_ == 0   ? "1 = 0"
                            : box_count_ == 1 ? conditions.front()
                                              : fmt::format("(({}))", fmt::join(conditions, ") OR ("));
    first = fmt::format("{} AND ({}", sum, first);
    edits_[condition_.end - 1].behind = ")";
  }

  /// Replaces the table by one scan per box.
  void scan_each(const std::vector<std::string>& conditions) {
    const std::string table = source(table_.tokens);
    std::string scans;
    for (const std::string& condition : conditions)
      scans +=
          fmt::format("{}SELECT * FROM {} WHERE {}", scans.empty() ? "" : " UNION ALL ", table, condition);
    const bool is_function = tokens_.is_sign(table_.tokens.end - 1, ")");
    const std::string& name = table_.alias.empty() && !is_function ? table_.name : table_.alias;
    std::string& first = edits_[table_.tokens.begin].text = fmt::format("({})", scans);
    if (!name.empty()) first += " AS " + name;
    drop(table_.tokens.begin + 1, condition_.begin - 1);
  }

  void drop(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) edits_[i].is_dropped = true;
  }

  const RewriteOptions& options_;
  TableReference table_;
  TokenRange condition_;
  std::size_t box_count_ = 0;
  double share_ = 1.0;
};

}  // namespace

PrunedStatement prune_statement(std::string_view sql) {
  return Pruner(sql).prune();
}

RewrittenStatement rewrite_statement(std::string_view sql, const RewriteOptions& options) {
  return Rewriter(sql, options).rewrite();
}

}  // namespace alidade::database
