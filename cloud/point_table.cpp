// SPDX-License-Identifier: MIT
#include "cloud/point_table.h"

#include <fmt/format.h>
#include <cmath>
#include <functional>
#include <iterator>

namespace alidade {

namespace {

/// Attribute and names of a role. Names are plain_name()s, the more usual one first.
struct RoleFacts {
  std::optional<Attribute> attribute;
  std::string_view names;
  std::string_view text_names = {};  ///< additional ones of NameRules::text
};

/// In the order of the roles.
constexpr RoleFacts k_role_facts[] = {
    {{}, "x", "easting east xcoordinate xcoord longitude lon"},
    {{}, "y", "northing north ycoordinate ycoord latitude lat"},
    {{}, "z", "elevation height zcoordinate zcoord altitude alt"},
    {Attribute::normal, "nx normalx"},
    {Attribute::normal, "ny normaly"},
    {Attribute::normal, "nz normalz"},
    {Attribute::color, "red r diffusered rf"},
    {Attribute::color, "green g diffusegreen gf"},
    {Attribute::color, "blue b diffuseblue bf"},
    {Attribute::color, ""},  // packed_color: assigned by the format
    {Attribute::near_infrared, "nearinfrared infrared nir"},
    {Attribute::intensity, "intensity", "i"},
    {Attribute::classification, "classification class"},
    {Attribute::returns, "returnnumber"},
    {Attribute::returns, "numberofreturns numreturns"},
    {Attribute::flags, "classflags"},
    {Attribute::flags, "scanchannel scannerchannel"},
    {Attribute::flags, "scandirectionflag"},
    {Attribute::flags, "edgeofflightline"},
    {Attribute::scan_angle, "scanangle scananglerank"},
    {Attribute::user_data, "userdata"},
    {Attribute::point_source_id, "pointsourceid"},
    {Attribute::gps_time, "gpstime time"},
    {Attribute::extra_dimensions, ""},
    {{}, ""},  // ignored
};
static_assert(std::size(k_role_facts) == static_cast<std::size_t>(ColumnRole::ignored) + 1);

std::string plain_name(std::string_view name) {
  std::string plain;
  for (const char character : name) {
    if (character == '_' || character == '-' || character == '.' || character == ' ') continue;
    plain += character >= 'A' && character <= 'Z' ? static_cast<char>(character - 'A' + 'a') : character;
  }
  constexpr std::string_view k_prefix = "scalar";
  if (plain.size() > k_prefix.size() && plain.starts_with(k_prefix)) plain.erase(0, k_prefix.size());
  return plain;
}

bool is_float(ScalarType type) {
  return type == ScalarType::float32 || type == ScalarType::float64;
}

}  // namespace

void assign_roles(std::vector<TableColumn>& columns, NameRules rules) {
  std::vector<std::string> plain;
  for (const TableColumn& column : columns) plain.push_back(plain_name(column.name));

  std::vector<std::string_view> names;
  const auto assign = [&](ColumnRole role, std::string_view role_names) {
    split_words(role_names, names);
    for (const std::string_view name : names) {
      if (find_role(columns, role)) return;
      for (std::size_t i = 0; i < columns.size(); ++i) {
        if (columns[i].role != ColumnRole::extra || plain[i] != name) continue;
        columns[i].role = role;
        break;
      }
    }
  };
  for (std::size_t role = 0; role < std::size(k_role_facts); ++role) {
    assign(static_cast<ColumnRole>(role), k_role_facts[role].names);
    if (rules == NameRules::text) assign(static_cast<ColumnRole>(role), k_role_facts[role].text_names);
  }

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
  return k_role_facts[static_cast<std::size_t>(role)].attribute;
}

ValueScaling color_scaling(ScalarType type, const ColumnRange& range) {
  if (range.max <= 0.0) return {};
  if (type == ScalarType::uint8 || type == ScalarType::int8) return {.factor = 257.0, .assumption = {}};
  if (is_float(type) && range.max <= 1.0)
    return {.factor = 65535.0, .assumption = "colours range from 0 to 1 because none is larger"};
  if (range.max <= 255.0) {
    const bool usual = type != ScalarType::uint16 && type != ScalarType::int16;
    return {.factor = 257.0, .assumption = usual ? "" : "colours are 8-bit values because none exceeds 255"};
  }
  return {};
}

ValueScaling intensity_scaling(ScalarType type, const ColumnRange& range, IntensityScale scale) {
  if (type == ScalarType::uint8) return {.factor = 257.0, .assumption = {}};
  if (type == ScalarType::uint16 || !(range.min <= range.max)) return {};
  if (range.min >= 0.0) {
    if (range.max == 0.0) return {};
    if (is_float(type) && range.max <= 1.0)
      return {.factor = 65535.0,
              .assumption = scale == IntensityScale::unit
                                ? ""
                                : "intensities range from 0 to 1 because none is larger"};
    if (range.max <= 255.0)
      return {.factor = 257.0, .assumption = "intensities range from 0 to 255 because none is larger"};
    if (range.max <= 65535.0) return {};
  }
  if (scale == IntensityScale::signed_12_bit && range.min >= -2048.0 && range.max <= 2047.0)
    return {.origin = -2048.0,
            .factor = 65535.0 / 4095.0,
            .assumption = "intensities range from -2048 to 2047 because some are negative"};
  const double spread = range.max - range.min;
  const bool usable = std::isfinite(spread) && spread > 0.0;
  return {.origin = usable ? range.min : 0.0,
          .factor = usable ? 65535.0 / spread : 0.0,
          .assumption = "intensities were scaled from their minimum and maximum to 0 .. 65535"};
}

double type_resolution(ScalarType type, double largest) {
  if (type == ScalarType::float64) return 0.0;
  if (type != ScalarType::float32) return 0.5;
  const float next = std::nextafter(static_cast<float>(largest), std::numeric_limits<float>::infinity());
  const double half = 0.5 * (static_cast<double>(next) - largest);
  return std::isfinite(half) ? half : 0.0;
}

std::optional<std::string> coarse_floats(const CoordinateSurvey& survey) {
  constexpr double k_share = 0.02;
  if (survey.finite_count < 2) return std::nullopt;
  const glm::dvec3 size = survey.bounds.size();
  std::array<double, 3> sides = {size.x, size.y, size.z};
  std::ranges::sort(sides, std::greater());
  const auto count = static_cast<double>(survey.finite_count);
  const double spacing =
      sides[1] > 0.0 ? std::sqrt(sides[0]) * std::sqrt(sides[1] / count) : sides[0] / count;
  std::string axes;
  for (int axis = 0; axis < 3; ++axis) {
    const double largest = std::max(std::abs(survey.bounds.min[axis]), std::abs(survey.bounds.max[axis]));
    const double resolution = survey.resolution[axis];
    if (!(2.0 * resolution > k_share * spacing) ||
        resolution != type_resolution(ScalarType::float32, largest))
      continue;
    axes += fmt::format("{}{} in steps of {}", axes.empty() ? "" : ", ", "xyz"[axis], 2.0 * resolution);
  }
  if (axes.empty()) return std::nullopt;
  return "the file stores coordinates as float32, which are rounded here: " + axes;
}

double meant_number(const ExtraDimension& dimension, const std::uint8_t* at) {
  return with_type(dimension.type, [&](auto none) {
    const auto stored = load<decltype(none)>(reinterpret_cast<const std::byte*>(at));
    if (dimension.no_data && is_mark(*dimension.no_data, stored))
      return std::numeric_limits<double>::quiet_NaN();
    const auto number = static_cast<double>(stored);
    // A scale or an offset that is not finite is ignored.
    const double scale = std::isfinite(dimension.scale) ? dimension.scale : 1.0;
    const double offset = std::isfinite(dimension.offset) ? dimension.offset : 0.0;
    return scale == 1.0 && offset == 0.0 ? number : offset + scale * number;
  });
}

Cell require_cell(const TextScanner& scanner, std::string_view word, ScalarType type) {
  if (type == ScalarType::uint64) {
    if (const auto count = parse_count(word)) return {static_cast<double>(*count), *count};
  }
  if (type == ScalarType::int64) {
    if (const auto whole = parse_count<std::int64_t>(word))
      return {static_cast<double>(*whole), static_cast<std::uint64_t>(*whole)};
  }
  if (type == ScalarType::uint64 || type == ScalarType::int64)
    scanner.fail("invalid value", "a 64-bit integer", quote(word));
  const auto number = parse_number(word);
  if (!number) scanner.fail("invalid value", "a number", quote(word));
  return {*number, 0};
}

}  // namespace alidade
