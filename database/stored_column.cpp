// SPDX-License-Identifier: MIT
#include "database/stored_column.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/words.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"

namespace alidade::database {
namespace {

/// Names of columns that every table has, in lower case; those of PostgreSQL last.
const std::set<std::string> k_taken = {"id",   "x",    "y",    "z",    "_chunk",  "ctid",
                                       "cmin", "cmax", "xmin", "xmax", "tableoid"};

/// Bytes of a name that PostgreSQL keeps.
constexpr std::size_t k_most_bytes = 63;

/// The first bytes of a name, at most so many, without a part of a character (UTF-8).
std::string cut(const std::string& name, std::size_t most) {
  if (name.size() <= most) return name;
  while (most > 0 && (static_cast<unsigned char>(name[most]) & 0xc0) == 0x80) --most;
  return name.substr(0, most);
}

/// A name that is the same in every database, script and terminal: control characters and bytes that
/// are not UTF-8 become '_'. SQL ends names at a byte of 0.
std::string readable(const std::string& name) {
  std::string text;
  for (std::string_view rest(name.c_str()); !rest.empty();) {
    const std::size_t size = utf8_character_size(rest);
    const auto first = static_cast<unsigned char>(rest.front());
    if (size == 0 || first < 0x20 || first == 0x7f)
      text += '_';
    else
      text += rest.substr(0, size);
    rest.remove_prefix(size == 0 ? 1 : size);
  }
  return text;
}

/// A name for a column that is not taken yet; it is taken then.
std::string free_name(const std::string& wanted, std::set<std::string>& taken) {
  const std::string given = readable(wanted);
  const std::string plain = given.empty() ? "unnamed" : cut(given, k_most_bytes);
  std::string name = plain;
  // In SQL, names are equal that differ only in the case of ASCII letters.
  for (int number = 2; !taken.insert(lower_case(name)).second; ++number) {
    const std::string end = fmt::format("_{}", number);
    name = cut(plain, k_most_bytes - end.size()) + end;
  }
  return name;
}

/// `otherwise` if the number is not given or not finite.
double finite_or(bool is_given, double number, double otherwise) {
  return is_given && std::isfinite(number) ? number : otherwise;
}

template <class Number>
ColumnValue meant_value(const StoredColumn& column, Number stored) {
  const double number = static_cast<double>(stored);
  if (column.no_data && is_mark(*column.no_data, stored)) return std::monostate{};
  if (column.is_scaled()) return column.offset + column.scale * number;
  if constexpr (std::is_integral_v<Number>) {
    if (std::in_range<std::int64_t>(stored)) return static_cast<std::int64_t>(stored);
    return static_cast<std::uint64_t>(stored);
  }
  return number;
}

}  // namespace

AttributeParts attribute_parts(Attribute attribute) {
  using enum ScalarType;
  static const AttributeParts k_parts[] = {
      {uint16, {"red", "green", "blue"}},
      {uint16, {"near_infrared"}},
      {uint16, {"intensity"}},
      {uint8, {"classification"}},
      {uint8, {"return_number", "number_of_returns"}},
      {uint8, {"flags"}},
      {float32, {"scan_angle"}},
      {uint8, {"user_data"}},
      {uint16, {"point_source_id"}},
      {float64, {"gps_time"}},
      {float32, {"normal_x", "normal_y", "normal_z"}},
  };  // in the order of the attributes' bits
  return k_parts[std::countr_zero(static_cast<std::uint32_t>(attribute))];
}

std::vector<StoredColumn> stored_columns(const PointCloud& cloud) {
  std::vector<StoredColumn> columns = {{.name = "id", .size = 8, .type = ScalarType::uint64}};
  std::set<std::string> taken = k_taken;
  int blob = 0;
  for_each_column(cloud, [&](Attribute attribute, const auto& column) {
    if (column.empty()) return;
    const AttributeParts parts = attribute_parts(attribute);
    const int size = scalar_size(parts.type), count = static_cast<int>(parts.names.size());
    ++blob;
    int byte = 0;
    for (const char* const part : parts.names) {
      columns.push_back({.name = free_name(part, taken),
                         .blob = blob,
                         .size = size * count,
                         .byte = byte,
                         .type = parts.type});
      byte += size;
    }
  });
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    columns.push_back({.name = free_name(dimension.name, taken),
                       .blob = ++blob,
                       .size = dimension.byte_count,
                       .type = dimension.type,
                       .scale = finite_or(dimension.has_scale, dimension.scale, 1.0),
                       .offset = finite_or(dimension.has_offset, dimension.offset, 0.0),
                       .no_data = dimension.no_data});
  }
  return columns;
}

std::vector<StoredColumn> stored_columns(AttributeSet attributes, std::vector<ExtraDimension> dimensions) {
  PointCloud cloud;
  cloud.extra_dimensions = std::move(dimensions);
  append_rows(cloud, attributes, 1);
  return stored_columns(cloud);
}

std::vector<StoredColumn> stored_columns(const AttributeColumns& columns) {
  std::vector<ExtraDimension> dimensions;
  for (const ExtraColumn& column : columns.extra_dimensions) dimensions.push_back(column.description);
  return stored_columns(columns.attributes(), std::move(dimensions));
}

std::vector<ValueBlob> value_blobs(const AttributeColumns& columns) {
  std::vector<ValueBlob> blobs;
  for_each_column(columns, [&](Attribute attribute, const auto& column) {
    if (column.empty()) return;
    const auto values = [&] {
      if constexpr (std::is_same_v<decltype(column), const ColorColumn&>)
        return column.deep().data();
      else
        return column.data();
    }();
    blobs.push_back(
        {reinterpret_cast<const std::byte*>(values), sizeof column[0], ValueBlob::number_of(attribute)});
  });
  std::size_t number = ValueBlob::number_of(Attribute::extra_dimensions);
  for (const ExtraColumn& column : columns.extra_dimensions) {
    blobs.push_back({reinterpret_cast<const std::byte*>(column.values.data()),
                     static_cast<std::size_t>(column.description.byte_count), number++});
  }
  return blobs;
}

void rename_earlier_columns(std::vector<StoredColumn>& columns) {
  for (std::size_t i = 1; i < columns.size(); ++i) {
    const bool is_earlier = columns[i].name == k_earlier_number_of_returns &&
                            columns[i - 1].name == "return_number" && columns[i].blob == columns[i - 1].blob;
    if (!is_earlier) continue;
    columns[i].name = "number_of_returns";
    // An extra dimension may have had this name.
    std::set<std::string> taken = k_taken;
    for (StoredColumn& column : columns) {
      if (column.blob != 0) column.name = free_name(column.name, taken);
    }
  }
}

std::string line_column(const std::vector<StoredColumn>& columns, std::string name) {
  const auto has_name = [&](const StoredColumn& column) { return lower_case(column.name) == name; };
  while (std::ranges::any_of(columns, has_name)) name = "ray_" + name;
  return name;
}

ColumnValue stored_value(const StoredColumn& column, const std::byte* at) {
  if (column.type == ScalarType::bytes) return std::span(at, static_cast<std::size_t>(column.size));
  return with_type(column.type, [&](auto none) { return meant_value(column, load<decltype(none)>(at)); });
}

std::vector<CloudColumn> cloud_columns(const PointColumns& cloud) {
  std::vector<CloudColumn> columns;
  for (int axis = 0; axis < 3; ++axis) {
    CloudColumn& column = columns.emplace_back();
    column.like.name = "xyz"[axis];
    column.axis = axis;
  }
  const std::vector<ValueBlob> blobs = value_blobs(cloud.attributes);
  for (StoredColumn& stored : stored_columns(cloud.attributes)) {
    if (stored.blob == 0) continue;
    CloudColumn& column = columns.emplace_back();
    column.values = blobs[static_cast<std::size_t>(stored.blob - 1)].values + stored.byte;
    column.like = std::move(stored);
  }
  return columns;
}

}  // namespace alidade::database
