// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/bytes.h"
#include "base/text_scanner.h"
#include "cloud/attributes.h"
#include "cloud/lattice.h"

namespace alidade {

/// The meaning of a column of a point table (PLY properties, PCD fields, columns of text).
enum class ColumnRole : std::uint8_t {
  x,
  y,
  z,
  normal_x,
  normal_y,
  normal_z,
  red,
  green,
  blue,
  packed_color,  ///< 0x00RRGGBB in one value (PCD)
  near_infrared,
  intensity,
  classification,
  return_number,
  return_count,
  class_flags,
  scanner_channel,
  scan_direction,
  edge_of_flight_line,  ///< together the PointFlags
  scan_angle,
  user_data,
  point_source_id,
  gps_time,
  extra,    ///< kept under its own name
  ignored,  ///< not kept
};

/// A column as the file declares it.
struct TableColumn {
  std::string name;
  ScalarType type = ScalarType::float64;
  ColumnRole role = ColumnRole::extra;
};

/// One value of a point table. `number` holds every type but 64-bit integers and packed colours without loss;
/// `integer` is set for those two only and holds their bits.
struct Cell {
  double number = 0.0;
  std::uint64_t integer = 0;
};

/// The cell for a word of the scanner's last line. Errors: the word is not a number or, for the 64-bit types,
/// not an integer that fits.
Cell require_cell(const TextScanner& scanner, std::string_view word, ScalarType type);

/// Which names have a role: x, y, z only, or also easting, latitude, height, ... and `i` for intensity.
enum class NameRules { point_format, text };

/// Assigns roles to columns that are still `extra`, by their names. Names are compared without case, `_`,
/// `-`, `.`, blanks and the prefix `scalar_`. Each role goes to one column, that of the more usual name; red,
/// green, blue and the components of a normal get roles only if all three are present. Other columns stay
/// `extra`.
void assign_roles(std::vector<TableColumn>& columns, NameRules rules);

/// Index of the column with this role, which is not `extra` or `ignored`; empty without such a column.
std::optional<std::size_t> find_role(std::span<const TableColumn> columns, ColumnRole role);

/// The attributes that these columns fill.
AttributeSet attributes_of(std::span<const TableColumn> columns);

/// The attribute that a role belongs to; empty for coordinates and ignored columns.
std::optional<Attribute> attribute_of(ColumnRole role);

/// The value at any address, aligned or not. Bytes are swapped if `order` is not that of the machine.
template <class Value>
Value load(const std::byte* at, std::endian order) {
  if (order == std::endian::native) return load<Value>(at);
  std::array<std::byte, sizeof(Value)> bytes;
  std::reverse_copy(at, at + sizeof(Value), bytes.begin());
  return std::bit_cast<Value>(bytes);
}

/// Calls visit(Value()) with the C++ type of a type; does nothing for ScalarType::bytes, which has none.
template <class Visit>
auto with_type(ScalarType type, const Visit& visit) {
  using Result = decltype(visit(0.0));
  switch (type) {
    case ScalarType::uint8:
      return visit(std::uint8_t());
    case ScalarType::int8:
      return visit(std::int8_t());
    case ScalarType::uint16:
      return visit(std::uint16_t());
    case ScalarType::int16:
      return visit(std::int16_t());
    case ScalarType::uint32:
      return visit(std::uint32_t());
    case ScalarType::int32:
      return visit(std::int32_t());
    case ScalarType::uint64:
      return visit(std::uint64_t());
    case ScalarType::int64:
      return visit(std::int64_t());
    case ScalarType::float32:
      return visit(float());
    case ScalarType::float64:
      return visit(double());
    case ScalarType::bytes:
      break;
  }
  return Result();
}

/// Whether a double cannot hold all values of a type: see Cell::integer.
template <class Value>
inline constexpr bool k_is_wide = std::is_integral_v<Value> && sizeof(Value) == sizeof(std::uint64_t);

/// The cell for the scalar_size(type) bytes at `bytes`.
inline Cell cell_from(const std::byte* bytes, ScalarType type, std::endian order) {
  return with_type(type, [&](auto none) {
    using Value = decltype(none);
    const Value value = load<Value>(bytes, order);
    return Cell{static_cast<double>(value), k_is_wide<Value> ? static_cast<std::uint64_t>(value) : 0};
  });
}

/// Whether a number is the nodata value (ExtraDimension::no_data), which is widened to 8 bytes: integers to a
/// signed or unsigned one, others to float64. A nodata value may have digits that the type lacks.
template <class Number>
bool is_mark(const std::array<std::uint8_t, 8>& mark, Number number) {
  using Wide = std::conditional_t<std::is_floating_point_v<Number>, double,
                                  std::conditional_t<std::is_signed_v<Number>, std::int64_t, std::uint64_t>>;
  const Wide wide = load<Wide>(reinterpret_cast<const std::byte*>(mark.data()));
  if constexpr (std::is_floating_point_v<Number>) {
    return (std::isnan(wide) && std::isnan(number)) || static_cast<Number>(wide) == number;
  } else {
    return wide == static_cast<Wide>(number);
  }
}

/// The scaled value of a point in an extra dimension; NaN for the nodata value. Requires a type of numbers.
double meant_number(const ExtraDimension& dimension, const std::uint8_t* at);

/// Smallest and largest of some values. NaN is ignored. Inverted without values.
struct ColumnRange {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  void grow(double value) {
    min = value < min ? value : min;
    max = value > max ? value : max;
  }
  /// Includes the values of another range, which may be empty.
  void grow(const ColumnRange& other) {
    min = other.min < min ? other.min : min;
    max = other.max > max ? other.max : max;
  }
};

/// How a file's values become 0 .. 65535: (value - origin) * factor, rounded and clamped; NaN becomes 0.
struct ValueScaling {
  double origin = 0.0;
  double factor = 1.0;
  std::string assumption;  ///< about the values, as a clause; empty if nothing had to be assumed

  std::uint16_t apply(double value) const {
    const double scaled = (value - origin) * factor + 0.5;
    return scaled >= 65535.0 ? 65535 : scaled > 0.0 ? static_cast<std::uint16_t>(scaled) : 0;
  }
};

/// The scaling of colour channels: 8-bit integers times 257. Other types by the largest value of the whole
/// file: floats up to 1 times 65535, values up to 255 times 257, larger ones unchanged.
ValueScaling color_scaling(ScalarType type, const ColumnRange& range);

/// The scale of intensities that a format defines.
enum class IntensityScale {
  free,           ///< nothing
  unit,           ///< 0 to 1 (PTX)
  signed_12_bit,  ///< -2048 to 2047, though many programs write 0 to 255 (PTS and its relatives)
};

/// The scaling of intensities: unsigned 8-bit integers times 257, unsigned 16-bit ones unchanged. Other types
/// by the range of the whole file: floats within 0 .. 1 times 65535; within 0 .. 255 times 257; within 0 ..
/// 65535 unchanged; within -2048 .. 2047 (the scale of PTS files, IntensityScale::signed_12_bit only)
/// linearly from that interval; anything else linearly from the smallest to the largest value.
ValueScaling intensity_scaling(ScalarType type, const ColumnRange& range, IntensityScale scale);

/// CoordinateSurvey::resolution of coordinates of a type, the largest of them being `largest`.
double type_resolution(ScalarType type, double largest);

/// A clause about axes of float32 coordinates whose steps are more than a fiftieth of the mean spacing of the
/// points in their box; empty if all steps are smaller. An axis has float32 coordinates if its resolution is
/// that of the type.
std::optional<std::string> coarse_floats(const CoordinateSurvey& survey);

}  // namespace alidade
