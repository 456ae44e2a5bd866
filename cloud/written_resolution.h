// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <string_view>

#include "base/text_scanner.h"
#include "cloud/column_roles.h"

namespace alidade {

/// How finely the coordinates of a text are written: the most decimals found on each axis.
class WrittenResolution {
 public:
  WrittenResolution() = default;
  explicit WrittenResolution(std::span<const TableColumn> columns)
      : columns_{find_role(columns, ColumnRole::x), find_role(columns, ColumnRole::y),
                 find_role(columns, ColumnRole::z)} {}

  /// Looks at the word in a column; words of other columns than coordinates cost nothing.
  void add(std::size_t column, std::string_view word) {
    for (int axis = 0; axis < 3; ++axis) {
      if (columns_[axis] != column) continue;
      const int decimals = written_decimals(word);
      if (!decimals_[axis] || decimals > *decimals_[axis]) decimals_[axis] = decimals;
    }
  }

  /// Half of the last written digit, per axis; 0 where nothing was written.
  glm::dvec3 resolution() const {
    glm::dvec3 result(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      if (decimals_[axis]) result[axis] = 0.5 * std::pow(10.0, -*decimals_[axis]);
    }
    return result;
  }

 private:
  std::optional<std::size_t> columns_[3];
  std::optional<int> decimals_[3];
};

}  // namespace alidade
