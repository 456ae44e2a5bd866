// SPDX-License-Identifier: MIT
#include "cloud/point_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>

namespace alidade {

namespace {

struct RoleName {
  ColumnRole role;
  const char* name;
};

// Where a role has several names, the more usual one stands first.
constexpr RoleName k_names[] = {{ColumnRole::x, "x"},
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
                                {ColumnRole::gps_time, "time"}};

constexpr RoleName k_text_names[] = {
    {ColumnRole::x, "easting"},   {ColumnRole::x, "east"},      {ColumnRole::x, "xcoordinate"},
    {ColumnRole::x, "xcoord"},    {ColumnRole::x, "longitude"}, {ColumnRole::x, "lon"},
    {ColumnRole::y, "northing"},  {ColumnRole::y, "north"},     {ColumnRole::y, "ycoordinate"},
    {ColumnRole::y, "ycoord"},    {ColumnRole::y, "latitude"},  {ColumnRole::y, "lat"},
    {ColumnRole::z, "elevation"}, {ColumnRole::z, "height"},    {ColumnRole::z, "zcoordinate"},
    {ColumnRole::z, "zcoord"},    {ColumnRole::z, "altitude"},  {ColumnRole::z, "alt"},
    {ColumnRole::intensity, "i"}};

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
  using enum Attribute;
  // In the order of the roles.
  static constexpr std::optional<Attribute> k_attributes[] = {{},
                                                              {},
                                                              {},
                                                              normal,
                                                              normal,
                                                              normal,
                                                              color,
                                                              color,
                                                              color,
                                                              color,
                                                              near_infrared,
                                                              intensity,
                                                              classification,
                                                              returns,
                                                              returns,
                                                              flags,
                                                              flags,
                                                              flags,
                                                              flags,
                                                              scan_angle,
                                                              user_data,
                                                              point_source_id,
                                                              gps_time,
                                                              extra_dimensions,
                                                              {}};
  static_assert(std::size(k_attributes) == static_cast<std::size_t>(ColumnRole::ignored) + 1);
  return k_attributes[static_cast<std::size_t>(role)];
}

namespace {

bool is_float(ScalarType type) {
  return type == ScalarType::float32 || type == ScalarType::float64;
}

}  // namespace

ValueScaling color_scaling(ScalarType type, const ColumnRange& range) {
  if (range.max <= 0.0) return {};
  if (type == ScalarType::uint8 || type == ScalarType::int8) return {.factor = 257.0, .assumption = {}};
  if (is_float(type) && range.max <= 1.0)
    return {.factor = 65535.0, .assumption = "colours go from 0 to 1 since none is larger"};
  if (range.max <= 255.0) {
    const bool usual = type != ScalarType::uint16 && type != ScalarType::int16;
    return {.factor = 257.0, .assumption = usual ? "" : "colours are 8-bit values since none exceeds 255"};
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
              .assumption =
                  scale == IntensityScale::unit ? "" : "intensities go from 0 to 1 since none is larger"};
    if (range.max <= 255.0)
      return {.factor = 257.0, .assumption = "intensities go from 0 to 255 since none is larger"};
    if (range.max <= 65535.0) return {};
  }
  if (scale == IntensityScale::signed_12_bit && range.min >= -2048.0 && range.max <= 2047.0)
    return {.origin = -2048.0,
            .factor = 65535.0 / 4095.0,
            .assumption = "intensities go from -2048 to 2047 since some are negative"};
  const double spread = range.max - range.min;
  const bool usable = std::isfinite(spread) && spread > 0.0;
  return {.origin = usable ? range.min : 0.0,
          .factor = usable ? 65535.0 / spread : 0.0,
          .assumption = "intensities were stretched from their own smallest and largest value to 0 .. 65535"};
}

double type_resolution(ScalarType type, double largest) {
  if (type == ScalarType::float64) return 0.0;
  if (type != ScalarType::float32) return 0.5;
  const float next = std::nextafter(static_cast<float>(largest), std::numeric_limits<float>::infinity());
  const double half = 0.5 * (static_cast<double>(next) - largest);
  return std::isfinite(half) ? half : 0.0;
}

PositionColumns::PositionColumns(std::span<const TableColumn> columns)
    : x_(find_role(columns, ColumnRole::x).value()),
      y_(find_role(columns, ColumnRole::y).value()),
      z_(find_role(columns, ColumnRole::z).value_or(0)),
      flat_(!find_role(columns, ColumnRole::z)) {}

TableSurvey::TableSurvey(std::span<const TableColumn> columns) : positions_(columns) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    switch (columns[i].role) {
      case ColumnRole::red:
      case ColumnRole::green:
      case ColumnRole::blue:
        watched_.push_back({i, &TableSurvey::colors_});
        break;
      case ColumnRole::near_infrared:
        watched_.push_back({i, &TableSurvey::near_infrared_});
        break;
      case ColumnRole::intensity:
        watched_.push_back({i, &TableSurvey::intensities_});
        break;
      default:
        break;
    }
  }
}

bool TableSurvey::add(std::span<const Cell> row) {
  const glm::dvec3 position = positions_.position(row);
  if (!(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z))) {
    ++dropped_count_;
    return false;
  }
  ++finite_count_;
  bounds_.grow(position);
  for (const Watched& watched : watched_) (this->*watched.range).grow(row[watched.column].number);
  return true;
}

Cell require_cell(const TextScanner& scanner, std::string_view word, ScalarType type) {
  if (type == ScalarType::uint64 || type == ScalarType::int64) {
    std::int64_t whole = 0;
    const char* const end = word.data() + word.size();
    if (type == ScalarType::uint64) {
      if (const auto count = parse_count(word)) return {static_cast<double>(*count), *count};
    } else if (const auto result = std::from_chars(word.data(), end, whole);
               result.ptr == end && result.ec == std::errc{}) {
      return {static_cast<double>(whole), static_cast<std::uint64_t>(whole)};
    }
    scanner.fail("not a whole number of 64 bits", "a whole number", quote(word));
  }
  const auto number = parse_number(word);
  if (!number) scanner.fail("not a number", "a number", quote(word));
  return {*number, 0};
}

}  // namespace alidade
