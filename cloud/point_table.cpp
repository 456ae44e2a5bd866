// SPDX-License-Identifier: MIT
#include "cloud/column_roles.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace alidade {

namespace {

struct RoleName {
  ColumnRole role;
  const char* name;
};

// Where a role has several names, the more usual one stands first.
constexpr RoleName k_names[] = {
    {ColumnRole::x, "x"},
    {ColumnRole::y, "y"},
    {ColumnRole::z, "z"},
    {ColumnRole::normal_x, "nx"},
    {ColumnRole::normal_x, "normalx"},
    {ColumnRole::normal_y, "ny"},
    {ColumnRole::normal_y, "normaly"},
    {ColumnRole::normal_z, "nz"},
    {ColumnRole::normal_z, "normalz"},
    {ColumnRole::red, "red"},
    {ColumnRole::red, "r"},
    {ColumnRole::red, "diffusered"},
    {ColumnRole::green, "green"},
    {ColumnRole::green, "g"},
    {ColumnRole::green, "diffusegreen"},
    {ColumnRole::blue, "blue"},
    {ColumnRole::blue, "b"},
    {ColumnRole::blue, "diffuseblue"},
    {ColumnRole::near_infrared, "nearinfrared"},
    {ColumnRole::near_infrared, "infrared"},
    {ColumnRole::near_infrared, "nir"},
    {ColumnRole::intensity, "intensity"},
    {ColumnRole::classification, "classification"},
    {ColumnRole::classification, "class"},
    {ColumnRole::return_number, "returnnumber"},
    {ColumnRole::return_count, "numberofreturns"},
    {ColumnRole::return_count, "numreturns"},
    {ColumnRole::class_flags, "classflags"},
    {ColumnRole::scanner_channel, "scanchannel"},
    {ColumnRole::scanner_channel, "scannerchannel"},
    {ColumnRole::scan_direction, "scandirectionflag"},
    {ColumnRole::edge_of_flight_line, "edgeofflightline"},
    {ColumnRole::scan_angle, "scanangle"},
    {ColumnRole::scan_angle, "scananglerank"},
    {ColumnRole::user_data, "userdata"},
    {ColumnRole::point_source_id, "pointsourceid"},
    {ColumnRole::gps_time, "gpstime"},
    {ColumnRole::gps_time, "time"},
};

constexpr RoleName k_text_names[] = {
    {ColumnRole::x, "easting"},   {ColumnRole::x, "east"},      {ColumnRole::x, "xcoordinate"},
    {ColumnRole::x, "xcoord"},    {ColumnRole::x, "longitude"}, {ColumnRole::x, "lon"},
    {ColumnRole::y, "northing"},  {ColumnRole::y, "north"},     {ColumnRole::y, "ycoordinate"},
    {ColumnRole::y, "ycoord"},    {ColumnRole::y, "latitude"},  {ColumnRole::y, "lat"},
    {ColumnRole::z, "elevation"}, {ColumnRole::z, "height"},    {ColumnRole::z, "zcoordinate"},
    {ColumnRole::z, "zcoord"},    {ColumnRole::z, "altitude"},  {ColumnRole::z, "alt"},
    {ColumnRole::intensity, "i"},
};

std::string plain_name(std::string_view name) {
  std::string plain;
  for (const char letter : name) {
    if (letter == '_' || letter == '-' || letter == '.' || letter == ' ') continue;
    plain += letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
  }
  constexpr std::string_view k_prefix = "scalar";
  if (plain.size() > k_prefix.size() && plain.starts_with(k_prefix)) plain.erase(0, k_prefix.size());
  return plain;
}

}  // namespace

void assign_roles(std::vector<TableColumn>& columns, NameRules rules) {
  std::vector<std::string> plain;
  for (const TableColumn& column : columns) plain.push_back(plain_name(column.name));

  const auto assign = [&](std::span<const RoleName> names) {
    for (const RoleName& candidate : names) {
      if (find_role(columns, candidate.role)) continue;
      for (std::size_t i = 0; i < columns.size(); ++i) {
        if (columns[i].role != ColumnRole::extra || plain[i] != candidate.name) continue;
        columns[i].role = candidate.role;
        break;
      }
    }
  };
  assign(k_names);
  if (rules == NameRules::text) assign(k_text_names);

  const auto keep_whole = [&](const std::array<ColumnRole, 3>& roles) {
    const auto is_one = [&](ColumnRole role) { return std::ranges::find(roles, role) != roles.end(); };
    const bool whole =
        std::ranges::all_of(roles, [&](ColumnRole role) { return find_role(columns, role).has_value(); });
    if (whole) return;
    for (TableColumn& column : columns) {
      if (is_one(column.role)) column.role = ColumnRole::extra;
    }
  };
  keep_whole({ColumnRole::red, ColumnRole::green, ColumnRole::blue});
  keep_whole({ColumnRole::normal_x, ColumnRole::normal_y, ColumnRole::normal_z});
}

std::optional<std::size_t> find_role(std::span<const TableColumn> columns, ColumnRole role) {
  const auto found = std::ranges::find(columns, role, &TableColumn::role);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

AttributeSet attributes_of(std::span<const TableColumn> columns) {
  AttributeSet set;
  for (const TableColumn& column : columns) {
    if (const auto attribute = attribute_of(column.role)) set = set | *attribute;
  }
  return set;
}

std::optional<Attribute> attribute_of(ColumnRole role) {
  switch (role) {
    case ColumnRole::x:
    case ColumnRole::y:
    case ColumnRole::z:
    case ColumnRole::ignored:
      return std::nullopt;
    case ColumnRole::normal_x:
    case ColumnRole::normal_y:
    case ColumnRole::normal_z:
      return Attribute::normal;
    case ColumnRole::red:
    case ColumnRole::green:
    case ColumnRole::blue:
    case ColumnRole::packed_color:
      return Attribute::color;
    case ColumnRole::near_infrared:
      return Attribute::near_infrared;
    case ColumnRole::intensity:
      return Attribute::intensity;
    case ColumnRole::classification:
      return Attribute::classification;
    case ColumnRole::return_number:
    case ColumnRole::return_count:
      return Attribute::returns;
    case ColumnRole::class_flags:
    case ColumnRole::scanner_channel:
    case ColumnRole::scan_direction:
    case ColumnRole::edge_of_flight_line:
      return Attribute::flags;
    case ColumnRole::scan_angle:
      return Attribute::scan_angle;
    case ColumnRole::user_data:
      return Attribute::user_data;
    case ColumnRole::point_source_id:
      return Attribute::point_source_id;
    case ColumnRole::gps_time:
      return Attribute::gps_time;
    case ColumnRole::extra:
      return Attribute::extra_dimensions;
  }
  return std::nullopt;
}

}  // namespace alidade
