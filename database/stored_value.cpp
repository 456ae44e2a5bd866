// SPDX-License-Identifier: MIT
#include "database/stored_value.h"

#include <cmath>
#include <type_traits>
#include <utility>

#include "base/bytes.h"

namespace alidade {
namespace {

/// Whether a number is the mark that was widened to 8 bytes: of whole numbers by their sign, of others to
/// float64.
template <class Number>
bool is_mark(const std::array<std::uint8_t, 8>& mark, Number number) {
  using Wide = std::conditional_t<std::is_floating_point_v<Number>, double,
                                  std::conditional_t<std::is_signed_v<Number>, std::int64_t, std::uint64_t>>;
  const Wide wide = load<Wide>(reinterpret_cast<const std::byte*>(mark.data()));
  if constexpr (std::is_floating_point_v<Number>) {
    // The mark may have digits that the type has not.
    return (std::isnan(wide) && std::isnan(number)) || static_cast<Number>(wide) == number;
  } else {
    return wide == static_cast<Wide>(number);
  }
}

template <class Number>
ColumnValue meant_value(const StoredColumn& column, Number stored) {
  const double number = static_cast<double>(stored);
  if (column.no_data && is_mark(*column.no_data, stored)) return std::monostate{};
  if (column.scale != 1.0 || column.offset != 0.0) return column.offset + column.scale * number;
  if constexpr (std::is_integral_v<Number>) {
    if (std::in_range<std::int64_t>(stored)) return static_cast<std::int64_t>(stored);
    return static_cast<std::uint64_t>(stored);
  }
  return number;
}

}  // namespace

ColumnValue stored_value(const StoredColumn& column, const std::byte* at) {
  switch (column.type) {
    case ScalarType::uint8:
      return meant_value(column, load<std::uint8_t>(at));
    case ScalarType::int8:
      return meant_value(column, load<std::int8_t>(at));
    case ScalarType::uint16:
      return meant_value(column, load<std::uint16_t>(at));
    case ScalarType::int16:
      return meant_value(column, load<std::int16_t>(at));
    case ScalarType::uint32:
      return meant_value(column, load<std::uint32_t>(at));
    case ScalarType::int32:
      return meant_value(column, load<std::int32_t>(at));
    case ScalarType::uint64:
      return meant_value(column, load<std::uint64_t>(at));
    case ScalarType::int64:
      return meant_value(column, load<std::int64_t>(at));
    case ScalarType::float32:
      return meant_value(column, load<float>(at));
    case ScalarType::float64:
      return meant_value(column, load<double>(at));
    case ScalarType::bytes:
      break;
  }
  return std::span(at, static_cast<std::size_t>(column.size));
}

}  // namespace alidade
