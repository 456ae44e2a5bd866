// SPDX-License-Identifier: MIT
#include "database/sqlite/distance_condition.h"

#include <algorithm>
#include <array>
#include <utility>

namespace alidade::database {
namespace {

constexpr std::size_t k_ray_arguments = 6, k_arguments = 9;

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
  if (column.begin == column.end) return std::nullopt;
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

void set_limit(DistanceCondition& condition, const std::string& sign, TokenRange limit) {
  if (sign != ">" && sign != ">=") condition.largest = limit;
  if (sign != "<" && sign != "<=") condition.least = limit;
}

ConditionAnswer reject(std::string reason) {
  return {.condition = {}, .reason = std::move(reason)};
}

constexpr const char* k_no_limit =
    "a distance is not compared with a single number, parameter, column or parenthesis between AND, OR and "
    "NOT";

}  // namespace

bool is_distance(const TokenList& tokens, std::size_t index) {
  if (!tokens.is_name(index) || !tokens.is_sign(index + 1, "(")) return false;
  const std::string name = plain_name(tokens.text(index));
  return name == "dist_ray" || name == "dist_plane";
}

std::string read_call(const TokenList& tokens, std::size_t index, DistanceCondition& condition) {
  condition.function = plain_name(tokens.text(index));
  std::vector<TokenRange> arguments = tokens.arguments(index + 1);
  if (arguments.size() != k_arguments) return condition.function + " does not have 9 arguments";
  std::optional<TokenRange> table;
  constexpr std::array<std::string_view, 3> k_names = {"x", "y", "z"};
  for (std::size_t i = 0; i < k_names.size(); ++i) {
    const std::optional<TokenRange> found = table_of(tokens, arguments[k_ray_arguments + i], k_names[i]);
    if (!found || (table && !same_names(tokens, *table, *found)))
      return "the last arguments of " + condition.function + " are not the columns x, y, z of one table";
    table = found;
  }
  condition.table = *table;
  arguments.resize(k_ray_arguments);
  if (!std::ranges::all_of(arguments, [&](TokenRange range) { return is_steady(tokens, range); }))
    return "a function among the arguments of " + condition.function + " may be volatile";
  condition.ray = std::move(arguments);
  return {};
}

bool ends_condition(const TokenList& tokens, std::size_t index) {
  return index >= tokens.size() || tokens.is_sign(index, ")") || tokens.is_sign(index, ",") ||
         tokens.is_sign(index, ";") ||
         tokens.is_one_of(index, {"and", "or", "where", "group", "having", "window", "order", "limit", "join",
                                  "left", "inner", "cross"});
}

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

ConditionAnswer read_condition(const TokenList& tokens, std::size_t begin) {
  DistanceCondition condition;
  std::size_t call = begin;
  std::vector<TokenRange> limits;
  if (!is_distance(tokens, begin)) {
    const std::optional<std::size_t> end = operand_end(tokens, begin);
    if (!end || comparison(tokens, *end, true).empty() || !is_distance(tokens, *end + 1)) return {};
    limits.push_back({begin, *end});
    set_limit(condition, comparison(tokens, *end, true), limits.back());
    call = *end + 1;
  }
  std::size_t end = tokens.closing(call + 1) + 1;
  if (limits.empty()) {
    const bool is_between = tokens.is_word(end, "between");
    const std::string sign = is_between ? ">=" : comparison(tokens, end, false);
    std::optional<std::size_t> limit_end = operand_end(tokens, end + 1);
    if (sign.empty() || !limit_end) return reject(k_no_limit);
    limits.push_back({end + 1, *limit_end});
    set_limit(condition, sign, limits.back());
    end = *limit_end;
    if (is_between) {
      limit_end = tokens.is_word(end, "and") ? operand_end(tokens, end + 1) : std::nullopt;
      if (!limit_end) return reject(k_no_limit);
      limits.push_back({end + 1, *limit_end});
      set_limit(condition, "<=", limits.back());
      end = *limit_end;
    }
  }
  if (!ends_condition(tokens, end)) return reject(k_no_limit);
  condition.tokens = {begin, end};
  if (std::string reason = read_call(tokens, call, condition); !reason.empty())
    return reject(std::move(reason));
  if (!std::ranges::all_of(limits, [&](TokenRange range) { return is_steady(tokens, range); }))
    return reject("a function in the limit of a distance may be volatile");
  return {.condition = std::move(condition), .reason = {}};
}

}  // namespace alidade::database
