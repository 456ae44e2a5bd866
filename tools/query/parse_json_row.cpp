// SPDX-License-Identifier: MIT
#include "tools/query/parse_json_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/json.h"
#include "tools/query/check_row.h"

namespace alidade {
namespace {

/// The line as a document; errors get the line's own number.
JsonDocument parse_line(const TextLine& line) {
  try {
    return parse_json(std::string(line.text), std::string(line.source));
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.place = fmt::format("{}{}", line.number, parts.place.substr(parts.place.find(':')));
    throw Error(std::move(parts));
  }
}

class RowFiller {
 public:
  RowFiller(const TextLine& line, const JsonDocument& document, const TargetKind& kind, std::span<double> row)
      : line_(line), document_(document), kind_(kind), row_(row) {
    std::ranges::fill(row_, std::numeric_limits<double>::quiet_NaN());
  }

  void fill() {
    const JsonValue& root = document_.root;
    if (const auto* object = std::get_if<JsonObject>(&root.data)) {
      for (const JsonMember& member : *object) take(member);
    } else if (const auto* array = std::get_if<JsonArray>(&root.data)) {
      if (array->size() < kind_.required_count() || array->size() > kind_.columns.size()) {
        line_.fail(root.begin, fmt::format("not a {}", kind_.name), fmt::format("[{}]", kind_.form()),
                   fmt::format("{} values", array->size()));
      }
      for (std::size_t i = 0; i < array->size(); ++i) put((*array)[i], i);
    } else {
      line_.fail(root.begin, fmt::format("not a {}", kind_.name), "an object or an array", found(root));
    }
    check_row(line_, kind_, row_, std::span(offsets_).first(row_.size()));
  }

 private:
  void take(const JsonMember& member) {
    const std::size_t column = kind_.column(member.key);
    if (column < kind_.columns.size()) return put(member.value, column);
    const auto vector = std::ranges::find(kind_.vectors, std::string_view(member.key), &TargetVector::name);
    if (vector == kind_.vectors.end()) {
      std::string known = kind_.names();
      for (const TargetVector& other : kind_.vectors) known += fmt::format(", {}", other.name);
      line_.fail(member.key_begin, "unknown key " + document_.quote(member.key_begin, member.key_end),
                 "some of " + known);
    }
    const auto* const array = std::get_if<JsonArray>(&member.value.data);
    if (array == nullptr || array->size() != 3) {
      line_.fail(member.value.begin, fmt::format("{} is not a vector", member.key),
                 "an array of three numbers", found(member.value));
    }
    for (std::size_t i = 0; i < 3; ++i) put((*array)[i], vector->first + i);
  }

  void put(const JsonValue& value, std::size_t i) {
    const TargetColumn& column = kind_.columns[i];
    offsets_[i] = value.begin;
    if (!std::isnan(row_[i])) line_.fail(value.begin, fmt::format("{} is given twice", column.name));
    if (std::holds_alternative<std::nullptr_t>(value.data) && !column.required) return;
    row_[i] = number(value, column);
    check_value(line_, value.begin, column, row_[i], found(value));
  }

  double number(const JsonValue& value, const TargetColumn& column) const {
    if (const auto* real = std::get_if<double>(&value.data)) return *real;
    if (const auto* whole = std::get_if<std::uint64_t>(&value.data)) return static_cast<double>(*whole);
    if (const auto* text = std::get_if<std::string>(&value.data)) {
      if (*text == "inf") return std::numeric_limits<double>::infinity();
      if (*text == "-inf") return -std::numeric_limits<double>::infinity();
    }
    line_.fail(value.begin, fmt::format("{} is not a number", column.name), "a number", found(value));
  }

  std::string found(const JsonValue& value) const { return document_.quote(value.begin, value.end); }

  const TextLine& line_;
  const JsonDocument& document_;
  const TargetKind& kind_;
  std::span<double> row_;
  std::array<std::size_t, k_most_target_columns> offsets_{};
};

}  // namespace

void parse_json_row(const TextLine& line, const TargetKind& kind, std::span<double> row) {
  const JsonDocument document = parse_line(line);
  RowFiller(line, document, kind, row).fill();
}

}  // namespace alidade
