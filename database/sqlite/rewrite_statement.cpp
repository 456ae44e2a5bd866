// SPDX-License-Identifier: MIT
#include "database/sqlite/rewrite_statement.h"

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
#include "database/sqlite/distance_condition.h"
#include "database/sqlite/sql_tokens.h"

namespace alidade::database {
namespace {

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
/// operations, of the columns of these names. Lengths in the unit of the coordinates; `direction`: the ray's
/// or the normal, of length 1. Products with 0 are omitted: they do not change sums of finite numbers.
std::string distance_expression(bool is_ray, const std::array<std::string, 3>& coordinates,
                                const glm::dvec3& origin, const glm::dvec3& direction) {
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

class Rewriter {
 public:
  Rewriter(std::string_view sql, const RewriteOptions& options)
      : sql_(sql), tokens_(sql, k_foreign_signs), options_(options) {
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
    for (std::size_t i = 0; i < tokens_.size(); ++i) texts_.emplace_back(tokens_.text(i));
    behind_.resize(tokens_.size());
    is_dropped_.resize(tokens_.size());
  }

  RewrittenStatement rewrite() {
    replace_distances();
    if (reason_ = reason_to_leave(); reason_.empty()) add_boxes();
    return {.text = text(), .reason = reason_, .box_count = box_count_, .share = share_};
  }

 private:
  std::string range_text(TokenRange range) const {
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

  std::array<glm::dvec3, 2> ray_of(const DistanceCondition& call) const {
    std::array<glm::dvec3, 2> ray{};
    for (std::size_t i = 0; i < call.ray.size(); ++i) {
      const std::optional<double> value = constant(tokens_, call.ray[i]);
      if (!value)
        reject(call.ray[i].begin, fmt::format("argument {} of {} is not constant", i + 1, call.function),
               "a number (other engines get the numbers of a ray, not its columns)", range_text(call.ray[i]));
      ray[i / 3][static_cast<int>(i % 3)] = *value;
    }
    return ray;
  }

  /// The columns x, y, z as written, since other engines distinguish upper and lower case in quoted names.
  std::array<std::string, 3> coordinates_of(const std::vector<TokenRange>& arguments) const {
    std::array<std::string, 3> names;
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
      const TokenRange column = arguments[arguments.size() - names.size() + axis];
      const std::size_t last = column.end - 1;
      if (tokens_.is(last, SqlTokenKind::quoted_name) && tokens_.text(last)[1] != "xyz"[axis])
        reject(last, "a quoted coordinate has capitals", "x, y, z", std::string(tokens_.text(last)));
      names[axis] = range_text(column);
    }
    return names;
  }

  void replace_distances() {
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      if (!is_distance(tokens_, i)) continue;
      DistanceCondition call;
      if (std::string reason = read_call(tokens_, i, call); !reason.empty())
        reject(i, std::move(reason),
               "dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) or dist_plane(px,py,pz, nx,ny,nz, x,y,z)");
      const auto [origin, direction] = ray_of(call);
      const bool is_ray = call.function == "dist_ray";
      const std::array<std::string, 3> coordinates = coordinates_of(tokens_.arguments(i + 1));
      const std::size_t end = tokens_.closing(i + 1);
      std::string& text = texts_[i] = distance_expression(
          is_ray, coordinates, origin,
          is_ray ? make_ray(origin, direction).direction : make_plane(origin, direction).normal);
      // Arrow's comparisons put -0 before 0.
      if (!is_ray && options_.dialect == SqlDialect::datafusion) text.insert(text.size() - 1, " + 0e+00");
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
    const std::optional<std::size_t> end = read_table(from + 1);
    if (!end || !tokens_.is_word(*end, "where")) return "it is not SELECT ... FROM one table WHERE ...";
    condition_.begin = *end + 1;
    condition_.end = condition_.begin;
    while (condition_.end < tokens_.size() && !tokens_.is_sign(condition_.end, ";") &&
           !tokens_.is_one_of(
               condition_.end,
               {"group", "having", "window", "order", "limit", "offset", "fetch", "qualify", "for", "union",
                "intersect", "except", "minus", "using", "sort", "cluster", "distribute", "lateral"})) {
      condition_.end =
          tokens_.is_sign(condition_.end, "(") ? tokens_.closing(condition_.end) + 1 : condition_.end + 1;
    }
    return condition_.begin == condition_.end ? "its condition is empty" : "";
  }

  /// Reads a table, a file's name or a function that reads one, with its alias. Returns the token after it.
  std::optional<std::size_t> read_table(std::size_t i) {
    table_.begin = i;
    if (tokens_.is_name(i)) {
      while (tokens_.is_sign(i + 1, ".") && tokens_.is_name(i + 2)) i += 2;
      table_name_ = tokens_.text(i);
    } else if (!tokens_.is(i, SqlTokenKind::text)) {
      return std::nullopt;
    }
    ++i;
    if (tokens_.is_sign(i, "(")) {
      i = tokens_.closing(i) + 1;
      table_name_.clear();
    }
    table_.end = i;
    if (tokens_.is_word(i, "as")) ++i;
    if (tokens_.is_name(i) && !tokens_.is_word(i, "where")) table_name_ = tokens_.text(i++);
    return i;
  }

  void note(std::string reason) {
    if (reason_.empty()) reason_ = std::move(reason);
  }

  /// Reads conditions between OR and moves `i` past them. Empty: no box can be left out.
  MayHold any_of(std::size_t& i, int depth) {
    std::vector<MayHold> parts{all_of(i, depth)};
    while (tokens_.is_word(i, "or")) parts.push_back(all_of(++i, depth));
    if (std::ranges::any_of(parts, [](const MayHold& part) { return !part; })) return {};
    if (parts.size() == 1) return parts.front();
    return [parts = std::move(parts)](const Bounds& box) {
      return std::ranges::any_of(parts, [&](const MayHold& part) { return part(box); });
    };
  }

  /// Reads conditions between AND.
  MayHold all_of(std::size_t& i, int depth) {
    std::vector<MayHold> parts;
    const auto add = [&](MayHold part) {
      if (part) parts.push_back(std::move(part));
    };
    add(condition(i, depth));
    while (tokens_.is_word(i, "and")) add(condition(++i, depth));
    if (parts.size() <= 1) return parts.empty() ? MayHold() : parts.front();
    return [parts = std::move(parts)](const Bounds& box) {
      return std::ranges::all_of(parts, [&](const MayHold& part) { return part(box); });
    };
  }

  MayHold condition(std::size_t& i, int depth) {
    if (tokens_.is_sign(i, "(") && ends_condition(tokens_, tokens_.closing(i) + 1) &&
        depth < k_deepest_parentheses) {
      std::size_t inner = i + 1;
      i = tokens_.closing(i) + 1;
      MayHold within = any_of(inner, depth + 1);
      return inner + 1 == i ? within : MayHold();
    }
    ConditionAnswer answer = read_condition(tokens_, i);
    if (answer.condition) {
      i = answer.condition->tokens.end;
      return limit_of(*answer.condition);
    }
    note(answer.reason);
    const std::size_t begin = i;
    i = end_of_condition(tokens_, i);
    for (std::size_t k = begin; k < i; ++k) {
      if (is_distance(tokens_, k)) note("a distance is part of a larger expression or below NOT");
    }
    return {};
  }

  std::optional<double> limit_value(const std::optional<TokenRange>& limit, double otherwise) {
    if (!limit) return otherwise;
    const std::optional<double> value = constant(tokens_, *limit);
    if (value) {
      texts_[limit->begin] = literal(*value);
      drop(limit->begin + 1, limit->end);
    }
    return value;
  }

  MayHold limit_of(const DistanceCondition& condition) {
    constexpr double k_infinite = std::numeric_limits<double>::infinity();
    const bool is_ray = condition.function == "dist_ray";
    const std::optional<double> low = limit_value(condition.least, is_ray ? 0.0 : -k_infinite);
    const std::optional<double> high = limit_value(condition.largest, k_infinite);
    if (!low || !high) {
      note("a limit on a distance is not constant");
      return {};
    }
    const auto [origin, direction] = ray_of(condition);
    PointFilter filter;
    if (is_ray)
      filter.lines.push_back({.ray = make_ray(origin, direction), .distance = {*low, *high}});
    else
      filter.planes.push_back({.plane = make_plane(origin, direction), .distance = {*low, *high}});
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
    std::size_t end = condition_.begin;
    const MayHold may_hold = any_of(end, 0);
    if (end != condition_.end) return note("its condition cannot be parsed");
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
    std::string& first = texts_[condition_.begin];
    const std::string sum = box_count_ == 0   ? "1 = 0"
                            : box_count_ == 1 ? conditions.front()
                                              : fmt::format("(({}))", fmt::join(conditions, ") OR ("));
    first = fmt::format("{} AND ({}", sum, first);
    behind_[condition_.end - 1] = ")";
  }

  /// Replaces the table by one scan per box.
  void scan_each(const std::vector<std::string>& conditions) {
    const std::string table = range_text(table_);
    std::string scans;
    for (const std::string& condition : conditions)
      scans +=
          fmt::format("{}SELECT * FROM {} WHERE {}", scans.empty() ? "" : " UNION ALL ", table, condition);
    texts_[table_.begin] = fmt::format("({})", scans);
    if (!table_name_.empty()) texts_[table_.begin] += " AS " + table_name_;
    drop(table_.begin + 1, condition_.begin - 1);
  }

  void drop(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) is_dropped_[i] = true;
  }

  std::string text() const {
    std::string text;
    std::size_t end = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      if (!is_dropped_[i]) text.append(sql_.substr(end, tokens_[i].begin - end)).append(texts_[i]);
      text += behind_[i];
      end = tokens_[i].end;
    }
    return text.append(sql_.substr(end));
  }

  std::string_view sql_;
  TokenList tokens_;
  const RewriteOptions& options_;
  std::vector<std::string> texts_, behind_;  ///< of the tokens, and what is added after them
  std::vector<bool> is_dropped_;             ///< tokens that are left out
  TokenRange table_, condition_;
  std::string table_name_;
  std::string reason_;
  std::size_t box_count_ = 0;
  double share_ = 1.0;
};

}  // namespace

RewrittenStatement rewrite_statement(std::string_view sql, const RewriteOptions& options) {
  return Rewriter(sql, options).rewrite();
}

}  // namespace alidade::database
