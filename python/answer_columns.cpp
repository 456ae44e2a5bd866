// SPDX-License-Identifier: MIT
#include "python/answer_columns.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "python/python_cloud.h"

namespace alidade::python {
namespace {

py::object object_of_cell(const Cell& cell) {
  return std::visit(
      []<class Value>(const Value& value) -> py::object {
        if constexpr (std::is_same_v<Value, std::monostate>)
          return py::none();
        else if constexpr (std::is_same_v<Value, std::string>)
          return text_of(value);
        else if constexpr (std::is_same_v<Value, std::vector<std::byte>>)
          return py::bytes(reinterpret_cast<const char*>(value.data()), value.size());
        else
          return py::cast(value);
      },
      cell);
}

/// The cell as a number, NaN for no value; none: it is no number, or a whole one that no double is.
std::optional<double> number_of(const Cell& cell) {
  constexpr std::int64_t k_largest_exact = std::int64_t{1} << 53;
  if (const auto* const whole = std::get_if<std::int64_t>(&cell))
    return *whole <= k_largest_exact && *whole >= -k_largest_exact ? std::optional<double>(*whole)
                                                                   : std::nullopt;
  if (const auto* const truth = std::get_if<bool>(&cell)) return *truth;
  if (const auto* const number = std::get_if<double>(&cell)) return *number;
  return std::holds_alternative<std::monostate>(cell) ? std::optional(k_no_number) : std::nullopt;
}

/// The text of the cell, empty if it has no value; null if it is not text, or ends with a NUL, which arrays of
/// NumPy cut off.
const std::string* text_of_cell(const Cell& cell) {
  static const std::string none;
  if (std::holds_alternative<std::monostate>(cell)) return &none;
  const auto* const text = std::get_if<std::string>(&cell);
  return text != nullptr && text->ends_with('\0') ? nullptr : text;
}

Cell cell_of(const visibility::Row& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  return {};
}

/// The columns of rows with the same names.
py::dict table_of_rows(std::span<const visibility::Row> rows) {
  py::dict columns;
  if (rows.empty()) return columns;
  for (const auto& member : rows.front().items())
    columns[text_of(member.key())] =
        column_of(rows.size(), [&](std::size_t i) { return cell_of(rows[i][member.key()]); });
  return columns;
}

}  // namespace

py::object texts_of(std::size_t count, const std::function<const std::string&(std::size_t)>& text) {
  py::list texts;
  for (std::size_t i = 0; i < count; ++i) texts.append(text_of(text(i)));
  return py::module_::import("numpy").attr("array")(texts, py::arg("dtype") = "U");
}

py::object column_of(std::size_t count, const std::function<Cell(std::size_t)>& cell) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < count; ++i) cells.push_back(cell(i));
  const auto are = [&]<class Value>(Value) {
    return !cells.empty() &&
           std::ranges::all_of(cells, [](const Cell& one) { return std::get_if<Value>(&one); });
  };
  const auto value = [&]<class Value>(Value) {
    return [&](std::size_t i) { return std::get<Value>(cells[i]); };
  };
  if (are(bool{})) return array_of(count, value(bool{}));
  if (are(std::int64_t{})) return array_of(count, value(std::int64_t{}));
  if (std::ranges::all_of(cells, [](const Cell& one) { return number_of(one).has_value(); }))
    return array_of(count, [&](std::size_t i) { return *number_of(cells[i]); });
  if (std::ranges::all_of(cells, text_of_cell))
    return texts_of(count, [&](std::size_t i) -> const std::string& { return *text_of_cell(cells[i]); });
  py::list objects;
  for (const Cell& one : cells) objects.append(object_of_cell(one));
  return py::module_::import("numpy").attr("array")(objects, py::arg("dtype") = "O");
}

py::object rows_of(std::span<const visibility::Row> rows, const Crs& crs, const py::dict& facts) {
  return answer_type("Rows")(table_of_rows(rows), object_of(crs), facts);
}

py::dict columns_of_points(const std::vector<jobs::ResultColumn>& columns, std::size_t count) {
  py::dict arrays;
  for (const jobs::ResultColumn& column : columns) {
    const char* const type = k_types[static_cast<std::size_t>(column.description.type)];
    py::array array{py::dtype(type), Shape{static_cast<py::ssize_t>(count)}};
    column.fill(0, count, static_cast<std::uint8_t*>(array.mutable_data()));
    arrays[text_of(column.description.name)] = array;
  }
  return arrays;
}

py::object points_of(const py::dict& columns, const py::dict& rows, const Crs& crs) {
  return answer_type("Points")(columns, rows, object_of(crs));
}

}  // namespace alidade::python
