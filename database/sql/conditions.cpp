// SPDX-License-Identifier: MIT
#include "database/sql/conditions.h"

#include <algorithm>
#include <array>
#include <utility>

namespace alidade::database {
namespace {

constexpr std::size_t k_line_arguments = 6, k_arguments = 9;

/// Whether an expression has one value within a row, however often it is evaluated: it calls no function.
bool is_steady(const TokenList& tokens, TokenRange range) {
  for (std::size_t i = range.begin; i < range.end; ++i) {
    // These words call functions of their name.
    if (tokens.is_one_of(i, {"like", "glob", "match", "regexp"})) return false;
    if (tokens.is_name(i) && tokens.is_sign(i + 1, "(")) return false;
    // These signs call functions, too, which fail for text that is not JSON.
    if (tokens.is_sign(i, "->") || tokens.is_sign(i, "->>")) return false;
  }
  return true;
}

/// The end of an operand that binds closer than any comparison: a literal, parameter, column or parentheses,
/// with signs before it; empty if there is something else.
std::optional<std::size_t> operand_end(const TokenList& tokens, std::size_t begin) {
  std::size_t i = begin;
  while (tokens.is_sign(i, "-") || tokens.is_sign(i, "+")) ++i;
  if (tokens.is_sign(i, "(")) return tokens.closing(i) + 1;
  for (const SqlTokenKind kind :
       {SqlTokenKind::number, SqlTokenKind::parameter, SqlTokenKind::text, SqlTokenKind::blob}) {
    if (tokens.is(i, kind)) return i + 1;
  }
  if (!tokens.is_name(i) || tokens.is_one_of(i, {"case", "cast", "exists", "not", "raise"}))
    return std::nullopt;
  ++i;
  while (tokens.is_sign(i, ".") && tokens.is_name(i + 1)) i += 2;
  if (tokens.is_sign(i, "(")) return std::nullopt;
  return i;
}

/// The comparison's sign with the distance on the left; empty if the comparison sets no limit.
std::string comparison(const TokenList& tokens, std::size_t index, bool is_reversed) {
  constexpr std::array<std::array<std::string_view, 2>, 6> k_signs = {
      {{"<", ">"}, {"<=", ">="}, {">", "<"}, {">=", "<="}, {"=", "="}, {"==", "="}}};
  for (const auto& [sign, reversed] : k_signs) {
    if (tokens.is_sign(index, sign)) return std::string(is_reversed ? reversed : sign);
  }
  return {};
}

/// The tokens before the name of a coordinate, with the dot; empty if the argument is not a column of that
/// name.
std::optional<TokenRange> table_of(const TokenList& tokens, TokenRange column, std::string_view name) {
  if (column.empty()) return std::nullopt;
  for (std::size_t i = column.begin; i < column.end; ++i) {
    const bool is_dot = (i - column.begin) % 2 == 1;
    if (is_dot ? !tokens.is_sign(i, ".") : !tokens.is_name(i)) return std::nullopt;
  }
  if (plain_name(tokens.text(column.end - 1)) != name) return std::nullopt;
  return TokenRange{column.begin, column.end - 1};
}

bool same_names(const TokenList& tokens, TokenRange a, TokenRange b) {
  if (a.end - a.begin != b.end - b.begin) return false;
  for (std::size_t i = 0; i < a.end - a.begin; ++i) {
    if (plain_name(tokens.text(a.begin + i)) != plain_name(tokens.text(b.begin + i))) return false;
  }
  return true;
}

constexpr const char* k_no_limit =
    "a distance is not compared with a single number, parameter, column or parenthesis between AND, OR and "
    "NOT";

/// Whether a condition in WHERE or ON ends before this token.
bool ends_condition(const TokenList& tokens, std::size_t index) {
  return index >= tokens.size() || tokens.is_sign(index, ")") || tokens.is_sign(index, ",") ||
         tokens.is_sign(index, ";") ||
         tokens.is_one_of(index, {"and", "or", "where", "group", "having", "window", "order", "limit", "join",
                                  "left", "inner", "cross"});
}

/// The end of any condition that begins at a token. An AND that belongs to BETWEEN does not end it.
std::size_t end_of_condition(const TokenList& tokens, std::size_t begin) {
  std::size_t i = begin;
  int between = 0, cases = 0;
  for (; i < tokens.size(); ++i) {
    if (tokens.is_sign(i, "(")) {
      i = tokens.closing(i);
    } else if (tokens.is_word(i, "case")) {
      ++cases;
    } else if (tokens.is_word(i, "end") && cases > 0) {
      --cases;
    } else if (tokens.is_word(i, "between") && cases == 0) {
      ++between;
    } else if (tokens.is_word(i, "and") && cases == 0 && between > 0) {
      --between;
    } else if (ends_condition(tokens, i) && cases == 0) {
      break;
    }
  }
  return i;
}

/// Reads the comparison of a distance that begins at a token. Returns a condition of another kind if there is
/// none, with the reason if it cannot be used; without its tokens.
Condition read_comparison(const TokenList& tokens, std::size_t begin) {
  Condition condition;
  const auto reject = [](std::string reason) { return Condition{.reason = std::move(reason)}; };
  const auto set_limit = [&](const std::string& sign, TokenRange limit) {
    if (sign != ">" && sign != ">=") condition.largest = limit;
    if (sign != "<" && sign != "<=") condition.least = limit;
  };
  std::size_t call = begin, end = 0;
  if (!is_distance(tokens, begin)) {
    const std::optional<std::size_t> limit_end = operand_end(tokens, begin);
    const std::string sign = limit_end ? comparison(tokens, *limit_end, true) : "";
    if (sign.empty() || !is_distance(tokens, *limit_end + 1)) return {};
    set_limit(sign, {begin, *limit_end});
    call = *limit_end + 1;
    end = tokens.closing(call + 1) + 1;
  } else {
    end = tokens.closing(call + 1) + 1;
    const bool is_between = tokens.is_word(end, "between");
    const std::string sign = is_between ? ">=" : comparison(tokens, end, false);
    std::optional<std::size_t> limit_end = operand_end(tokens, end + 1);
    if (sign.empty() || !limit_end) return reject(k_no_limit);
    set_limit(sign, {end + 1, *limit_end});
    end = *limit_end;
    if (is_between) {
      limit_end = tokens.is_word(end, "and") ? operand_end(tokens, end + 1) : std::nullopt;
      if (!limit_end) return reject(k_no_limit);
      set_limit("<=", {end + 1, *limit_end});
      end = *limit_end;
    }
  }
  if (!ends_condition(tokens, end)) return reject(k_no_limit);
  if (std::string reason = read_call(tokens, call, condition.call); !reason.empty())
    return reject(std::move(reason));
  for (const std::optional<TokenRange>& limit : {condition.least, condition.largest}) {
    if (limit && !is_steady(tokens, *limit))
      return reject("a function in the limit of a distance may be volatile");
  }
  condition.kind = Condition::Kind::distance;
  condition.comparison = {begin, end};
  return condition;
}

/// Reads one condition, which may be several in parentheses.
Condition read_one(const TokenList& tokens, std::size_t begin, int depth);

/// Reads conditions between `word`; a single one is not a part of another.
template <class ReadPart>
Condition read_parts(const TokenList& tokens, std::size_t begin, Condition::Kind kind, std::string_view word,
                     const ReadPart& read_part) {
  Condition condition{.kind = kind};
  condition.parts.push_back(read_part(begin));
  while (tokens.is_word(condition.parts.back().tokens.end, word))
    condition.parts.push_back(read_part(condition.parts.back().tokens.end + 1));
  condition.tokens = {begin, condition.parts.back().tokens.end};
  return condition.parts.size() > 1 ? std::move(condition) : std::move(condition.parts.front());
}

Condition read_any(const TokenList& tokens, std::size_t begin, int depth) {
  using Kind = Condition::Kind;
  return read_parts(tokens, begin, Kind::any, "or", [&](std::size_t first) {
    return read_parts(tokens, first, Kind::all, "and",
                      [&](std::size_t i) { return read_one(tokens, i, depth); });
  });
}

Condition read_one(const TokenList& tokens, std::size_t begin, int depth) {
  std::size_t i = begin;
  while (tokens.is_word(i, "not")) ++i;
  Condition condition;
  if (tokens.is_sign(i, "(") && ends_condition(tokens, tokens.closing(i) + 1)) {
    const std::size_t closing = tokens.closing(i);
    if (depth < k_deepest_parentheses) {
      condition = read_any(tokens, i + 1, depth + 1);
      condition.is_whole = condition.is_whole && condition.tokens.end == closing;
    } else {
      condition.reason = "it has too many parentheses";
    }
    condition.tokens = {i, closing + 1};
  } else {
    condition = read_comparison(tokens, i);
    const bool is_distance = condition.kind == Condition::Kind::distance;
    condition.tokens = {i, is_distance ? condition.comparison.end : end_of_condition(tokens, i)};
  }
  condition.is_negated = condition.is_negated || i > begin;
  return condition;
}

}  // namespace

bool is_distance(const TokenList& tokens, std::size_t index) {
  if (!tokens.is_name(index) || !tokens.is_sign(index + 1, "(")) return false;
  const std::string name = plain_name(tokens.text(index));
  return name == "dist_ray" || name == "dist_plane";
}

std::string read_call(const TokenList& tokens, std::size_t index, DistanceCall& call) {
  call.function = plain_name(tokens.text(index));
  call.kind = call.function == "dist_ray" ? DistanceKind::ray : DistanceKind::plane;
  std::vector<TokenRange> arguments = tokens.arguments(index + 1);
  if (arguments.size() != k_arguments) return call.function + " does not have 9 arguments";
  std::optional<TokenRange> table;
  constexpr std::array<std::string_view, 3> k_names = {"x", "y", "z"};
  for (std::size_t i = 0; i < k_names.size(); ++i) {
    call.coordinates[i] = arguments[k_line_arguments + i];
    const std::optional<TokenRange> found = table_of(tokens, call.coordinates[i], k_names[i]);
    if (!found || (table && !same_names(tokens, *table, *found)))
      return "the last arguments of " + call.function + " are not the columns x, y, z of one table";
    table = found;
  }
  call.table = *table;
  arguments.resize(k_line_arguments);
  if (!std::ranges::all_of(arguments, [&](TokenRange range) { return is_steady(tokens, range); }))
    return "a function among the arguments of " + call.function + " may be volatile";
  call.line = std::move(arguments);
  return {};
}

Condition read_conditions(const TokenList& tokens, std::size_t begin) {
  return read_any(tokens, begin, 0);
}

}  // namespace alidade::database
