// SPDX-License-Identifier: MIT
#include "tools/sql/sql_parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "octree/error.h"

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

template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
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
  if (value == "NULL" || value == "null") return parameter;
  if (const auto integer = whole_number<std::int64_t>(value)) {
    parameter.value = *integer;
  } else if (const auto real = whole_number<double>(value)) {
    parameter.value = *real;
  } else {
    const bool is_quoted = value.size() >= 2 && value.front() == '\'' && value.back() == '\'';
    parameter.value = std::string(is_quoted ? value.substr(1, value.size() - 2) : value);
  }
  return parameter;
}

void bind_parameters(sqlite3_stmt* statement, std::vector<SqlParameter>& parameters) {
  for (int place = 1; place <= sqlite3_bind_parameter_count(statement); ++place) {
    const char* const sign_and_name = sqlite3_bind_parameter_name(statement, place);
    const std::string name = sign_and_name == nullptr || *sign_and_name == '?' ? "" : sign_and_name + 1;
    int unnamed_before = 0;
    const auto found = std::ranges::find_if(parameters, [&](const SqlParameter& parameter) {
      return parameter.name == name && (!name.empty() || ++unnamed_before == place);
    });
    if (found == parameters.end()) {
      throw Error({.problem = name.empty() ? fmt::format("parameter {} has no value", place)
                                           : fmt::format("parameter {} has no value", sign_and_name),
                   .expected = name.empty() ? "--param VALUE for each, in their order"
                                            : fmt::format("--param {}=VALUE", name)});
    }
    bind(statement, place, *found);
  }
}

}  // namespace alidade
