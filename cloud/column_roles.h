// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud/attributes.h"

namespace alidade {

/// What a column of a point table (PLY properties, PCD fields, columns of text) is read as.
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

/// Which names stand for coordinates: x, y, z only, or also easting, latitude, height, ... and `i` for
/// intensity.
enum class NameRules { point_format, text };

/// Gives every column that is still `extra` its role by its name. Names are compared without case, `_`, `-`,
/// `.`, blanks and the prefix `scalar_`. A role goes to one column only, to the more usual of two names; red,
/// green, blue and the parts of a normal count only if all three are there. What remains is extra.
void assign_roles(std::vector<TableColumn>& columns, NameRules rules);

/// Place of the column with this role, which is not `extra` or `ignored`.
std::optional<std::size_t> find_role(std::span<const TableColumn> columns, ColumnRole role);

/// The attributes these columns fill.
AttributeSet attributes_of(std::span<const TableColumn> columns);

/// The attribute a role belongs to; empty for coordinates and ignored columns.
std::optional<Attribute> attribute_of(ColumnRole role);

}  // namespace alidade
