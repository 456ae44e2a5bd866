// SPDX-License-Identifier: MIT
#include "database/sqlite/plain_sql.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

namespace alidade::database {
namespace {

/// "(name - origin) * factor"; empty if the factor is 0.
std::string product(const std::string& name, double origin, double factor) {
  if (factor == 0.0) return {};
  const std::string difference =
      origin == 0.0 ? name
                    : fmt::format("({} {} {})", name, origin < 0.0 ? '+' : '-', literal(std::fabs(origin)));
  return fmt::format("{} * {}", difference, literal(factor));
}

}  // namespace
std::string literal(double number) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::scientific).ptr;
  return {text.data(), end};
}

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

}  // namespace alidade::database
