// SPDX-License-Identifier: MIT
#include "tools/query/check_row.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text_scanner.h"

namespace alidade {
namespace {

constexpr double k_largest_number = 9007199254740992.0;  // 2^53: up to here doubles are exact

/// What a value must be; nullptr if it is.
const char* expectation(ValueRule rule, double value) {
  switch (rule) {
    case ValueRule::place:
      return std::isfinite(value) ? nullptr : "a finite number";
    case ValueRule::limit:
      return std::isnan(value) ? "a number, also inf or -inf" : nullptr;
    case ValueRule::width:
      return std::isfinite(value) && value >= 0.0 ? nullptr : "a finite number, at least 0";
    case ValueRule::half_angle:
      return value >= 0.0 && value < 90.0 ? nullptr : "degrees, at least 0 and less than 90";
    case ValueRule::number:
      return value >= 0.0 && value <= k_largest_number && value == std::floor(value)
                 ? nullptr
                 : "a whole number from 0 to 2^53";
  }
  return nullptr;
}

}  // namespace

void check_value(const TextLine& line, std::size_t offset, const TargetColumn& column, double value,
                 std::string_view found) {
  const char* const expected = expectation(column.rule, value);
  if (expected != nullptr)
    line.fail(offset, fmt::format("{} is out of range", column.name), expected, quote(found));
}

void check_row(const TextLine& line, const TargetKind& kind, std::span<const double> row,
               std::span<const std::size_t> offsets) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (kind.columns[i].required && std::isnan(row[i]))
      line.fail(offsets[i], fmt::format("no value for {}", kind.columns[i].name), kind.form());
  }
  for (const TargetVector& vector : kind.vectors) {
    const std::size_t x = vector.first;
    if (!vector.is_direction || row[x] != 0.0 || row[x + 1] != 0.0 || row[x + 2] != 0.0) continue;
    line.fail(offsets[x], fmt::format("{} of the {} has length zero", vector.name, kind.name),
              "a direction of any other length", "0,0,0");
  }
}

}  // namespace alidade
