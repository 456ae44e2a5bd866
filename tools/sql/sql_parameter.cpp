// SPDX-License-Identifier: MIT
#include "tools/sql/sql_parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace alidade {
namespace {

bool is_name(std::string_view text) {
  const auto is_letter = [](char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || letter == '_';
  };
  return !text.empty() && is_letter(text.front()) && std::ranges::all_of(text, [&](char letter) {
    return is_letter(letter) || (letter >= '0' && letter <= '9');
  });
}

/// As SQL has them: without blanks around, and with a plus if that stands there.
std::optional<SqlParameter::Value> sql_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  // What else begins a number elsewhere, such as inf and nan, is text in SQL.
  const std::string_view unsigned_text = text.substr(text.starts_with('-') ? 1 : 0);
  if (unsigned_text.find_first_of(".0123456789") != 0) return std::nullopt;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  std::int64_t integer = 0;
  if (const auto [stop, error] = std::from_chars(begin, end, integer); stop == end && error == std::errc())
    return integer;
  double real = 0;
  const auto [stop, error] = std::from_chars(begin, end, real);
  if (stop != end) return std::nullopt;
  // Beyond what a double holds SQL has infinities, and zero for what is too small.
  return error == std::errc() ? real : std::strtod(std::string(text).c_str(), nullptr);
}

SqlParameter::Value sql_value(std::string_view text) {
  if (text == "NULL" || text == "null") return {};
  constexpr const char* k_blanks = " \t\n\v\f\r";
  const std::size_t first = text.find_first_not_of(k_blanks);
  if (first != std::string_view::npos) {
    const std::string_view word = text.substr(first, text.find_last_not_of(k_blanks) + 1 - first);
    if (std::optional<SqlParameter::Value> value = sql_number(word)) return std::move(*value);
    // As text it would be above every number.
    if (std::string_view("0123456789.+-").find(word.front()) != std::string_view::npos)
      throw Error({.file = "--param",
                   .problem = "begins like a number and is none",
                   .expected = "a number, or text in quotes: \"'TEXT'\"",
                   .found = std::string(text)});
  }
  if (text.size() < 2 || text.front() != '\'' || text.back() != '\'') return std::string(text);
  std::string inner;
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    inner += text[i];
    if (text.substr(i).starts_with("''")) ++i;
  }
  return inner;
}

void bind(sqlite3_stmt* statement, int place, SqlParameter& parameter) {
  parameter.is_used = true;
  int result = SQLITE_OK;
  if (const auto* const integer = std::get_if<std::int64_t>(&parameter.value)) {
    result = sqlite3_bind_int64(statement, place, *integer);
  } else if (const auto* const real = std::get_if<double>(&parameter.value)) {
    result = sqlite3_bind_double(statement, place, *real);
  } else if (const auto* const text = std::get_if<std::string>(&parameter.value)) {
    result = sqlite3_bind_text64(statement, place, text->data(), text->size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  if (result != SQLITE_OK) throw Error({.file = "--param", .problem = sqlite3_errstr(result)});
}

}  // namespace

SqlParameter parse_sql_parameter(const std::string& text) {
  SqlParameter parameter;
  std::string_view value = text;
  const std::size_t equals = value.find('=');
  if (equals != std::string_view::npos && is_name(value.substr(0, equals))) {
    parameter.name = value.substr(0, equals);
    value.remove_prefix(equals + 1);
  }
  parameter.value = sql_value(value);
  return parameter;
}

void bind_parameters(sqlite3_stmt* statement, std::vector<SqlParameter>& parameters) {
  int named = 0;
  for (int place = 1; place <= sqlite3_bind_parameter_count(statement); ++place) {
    const char* const sign_and_name = sqlite3_bind_parameter_name(statement, place);
    const bool is_numbered = sign_and_name != nullptr && *sign_and_name == '?';
    const std::string name = sign_and_name == nullptr || is_numbered ? "" : sign_and_name + 1;
    if (!name.empty()) ++named;
    // SQLite counts those with names, too; a number in the text is meant as it stands.
    const int wanted = is_numbered ? place : place - named;
    int unnamed_before = 0;
    const auto found = std::ranges::find_if(parameters, [&](const SqlParameter& parameter) {
      return parameter.name == name && (!name.empty() || ++unnamed_before == wanted);
    });
    if (found == parameters.end()) {
      throw Error({.problem = name.empty() ? fmt::format("parameter {} has no value", wanted)
                                           : fmt::format("parameter {} has no value", sign_and_name),
                   .expected = name.empty() ? "--param VALUE for each, in their order"
                                            : fmt::format("--param {}=VALUE", name)});
    }
    bind(statement, place, *found);
  }
}

}  // namespace alidade
