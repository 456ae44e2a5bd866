// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "cloud/crs.h"
#include "jobs/write_points.h"
#include "python/python_arrays.h"
#include "visibility/row_text.h"

// Columns of numbers and texts, of which the named tuples of alidade/_answers.py consist.

namespace alidade::python {

inline constexpr double k_no_number = std::numeric_limits<double>::quiet_NaN();

/// The number i of `count` as an array: value(i).
template <class Value>
py::array array_of(std::size_t count, const Value& value) {
  py::array_t<std::decay_t<decltype(value(0))>> array(static_cast<py::ssize_t>(count));
  auto* const to = array.mutable_data();
  for (std::size_t i = 0; i < count; ++i) to[i] = value(i);
  return array;
}

/// Texts as an array of str.
py::object texts_of(std::size_t count, const std::function<const std::string&(std::size_t)>& text);

/// A value of a row; none: no value.
using Cell = std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<std::byte>>;

/// The values of a column in an array of one kind: bool; whole numbers; numbers, NaN for no value; texts; or
/// else objects.
py::object column_of(std::size_t count, const std::function<Cell(std::size_t)>& cell);

/// alidade.Rows of rows with the same names.
py::object rows_of(std::span<const visibility::Row> rows, const Crs& crs, const py::dict& facts = {});

/// The columns that a job adds to so many points.
py::dict columns_of_points(const std::vector<jobs::ResultColumn>& columns, std::size_t count);

/// alidade.Points.
py::object points_of(const py::dict& columns, const py::dict& rows, const Crs& crs);

}  // namespace alidade::python
