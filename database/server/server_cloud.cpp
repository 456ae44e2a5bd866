// SPDX-License-Identifier: MIT
#include "database/server/server_cloud.h"

#include <fmt/format.h>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/name_errors.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

bool is_real(ScalarType type) {
  return type == ScalarType::float32 || type == ScalarType::float64;
}

/// The largest value of an integer attribute.
double largest(Attribute attribute, ScalarType type) {
  constexpr double k_most_returns = 15.0;
  if (attribute == Attribute::returns) return k_most_returns;
  return type == ScalarType::uint8 ? std::numeric_limits<std::uint8_t>::max()
                                   : std::numeric_limits<std::uint16_t>::max();
}

std::int64_t least(ScalarType type) {
  return with_type(
      type, [](auto none) { return static_cast<std::int64_t>(std::numeric_limits<decltype(none)>::min()); });
}

/// The column of a part of an attribute, also under its name in tables of earlier versions; null without one.
const NumberColumn* part_column(const ServerTable& table, std::string_view name) {
  const NumberColumn* const column = table.find(name);
  return column == nullptr && name == "number_of_returns" ? table.find(k_earlier_number_of_returns) : column;
}

ExtraDimension dimension_of(const NumberColumn& column) {
  ExtraDimension dimension;
  dimension.name = column.name;
  dimension.type = column.type;
  dimension.byte_count = scalar_size(column.type);
  if (column.can_be_null && column.is_whole())
    dimension.no_data = std::bit_cast<std::array<std::uint8_t, 8>>(least(column.type));
  return dimension;
}

void store_whole(ScalarType type, std::int64_t value, std::byte* at) {
  with_type(type, [&](auto none) { store(at, static_cast<decltype(none)>(value)); });
}

/// The value of a field, in the type of its column.
template <class Number>
Number sent(const NumberColumn& column, CopyField field) {
  if (field.size() != static_cast<std::size_t>(scalar_size(column.type))) {
    throw input_error(fmt::format("the server sent a value of the wrong size for {}", column.name),
                      fmt::format("{} bytes", scalar_size(column.type)), std::to_string(field.size()));
  }
  return with_type(column.type, [&](auto none) {
    return static_cast<Number>(load<decltype(none)>(field.data(), std::endian::big));
  });
}

constexpr std::size_t k_axes = 3, k_first_value = 4;  // of a row's fields: x, y, z, id, values

std::string copy_statement(const ServerTable& table, const RowChoice& choice) {
  std::string sql = "COPY (SELECT ";
  for (const char* const axis : {"x", "y", "z"}) sql += table.find(axis)->expression() + "::float8, ";
  sql += choice.has_ids ? table.find("id")->expression() + "::int8" : "0::int8";
  for (const ValueColumn& column : choice.columns) sql += ", " + column.column.expression();
  sql += " FROM " + table.quoted_name + " WHERE " + table.has_position();
  if (!choice.condition.empty()) sql += " AND (" + choice.condition + ")";
  if (choice.is_sorted) sql += " ORDER BY id";
  return sql + ") TO STDOUT (FORMAT binary)";
}

}  // namespace

std::int64_t whole_of(const NumberColumn& column, CopyField field) {
  return sent<std::int64_t>(column, field);
}

double number_of(const NumberColumn& column, CopyField field) {
  return sent<double>(column, field);
}

std::vector<ValueColumn> value_columns(const ServerTable& table, bool without_id) {
  std::vector<ValueColumn> columns;
  for (const NumberColumn& column : table.columns) {
    const std::string& name = column.name;
    const bool is_coordinate = name == "x" || name == "y" || name == "z";
    if (!is_coordinate && !(without_id && name == "id")) columns.push_back({column});
  }
  const PointCloud any;
  for_each_column(any, [&](Attribute attribute, const auto&) {
    const AttributeParts parts = attribute_parts(attribute);
    std::vector<std::string> names;
    for (const char* const name : parts.names) {
      const NumberColumn* const column = part_column(table, name);
      if (column == nullptr || !(is_real(parts.type) || column->is_whole())) return;
      names.push_back(column->name);
    }
    for (std::size_t part = 0; part < names.size(); ++part) {
      for (ValueColumn& column : columns) {
        if (column.column.name != names[part]) continue;
        column.attribute = attribute;
        column.part = part;
      }
    }
  });
  return columns;
}

AttributeSet attributes_of(std::span<const ValueColumn> columns) {
  AttributeSet all;
  for (const ValueColumn& column : columns)
    all = all | column.attribute.value_or(Attribute::extra_dimensions);
  return all;
}

std::vector<ValueColumn> kept_columns(std::span<const ValueColumn> columns, AttributeSet wanted) {
  std::vector<ValueColumn> kept;
  for (const ValueColumn& column : columns) {
    if (wanted.contains(column.attribute.value_or(Attribute::extra_dimensions))) kept.push_back(column);
  }
  return kept;
}

CloudValues::CloudValues(PointCloud& cloud, std::vector<ValueColumn> columns) : cloud_(cloud) {
  for (ValueColumn& column : columns) {
    Target target{.source = std::move(column), .type = ScalarType::float64};
    if (target.source.attribute) {
      const Attribute attribute = *target.source.attribute;
      target.type = attribute_parts(attribute).type;
      target.most = largest(attribute, target.type);
    } else {
      target.type = target.source.column.type;
      target.dimension = find_extra_dimension(cloud, dimension_of(target.source.column));
    }
    targets_.push_back(std::move(target));
  }
}

void CloudValues::find_columns() {
  for (Target& target : targets_) {
    if (!target.source.attribute) {
      target.values = reinterpret_cast<std::byte*>(cloud_.extra_dimensions[target.dimension].values.data());
      target.stride = static_cast<std::size_t>(scalar_size(target.type));
      continue;
    }
    for_each_column(cloud_, cloud_, [&](Attribute attribute, auto& column, const auto&) {
      if (attribute != *target.source.attribute) return;
      const std::size_t offset = target.source.part * static_cast<std::size_t>(scalar_size(target.type));
      target.values = reinterpret_cast<std::byte*>(column.data()) + offset;
      target.stride = sizeof column.front();
    });
  }
}

bool CloudValues::put(const Target& target, std::size_t row, CopyField field) {
  std::byte* const at = target.values + row * target.stride;
  const NumberColumn& column = target.source.column;
  if (is_real(target.type)) {
    const double number = field.empty() ? std::numeric_limits<double>::quiet_NaN() : number_of(column, field);
    if (target.type == ScalarType::float64) {
      store(at, number);
      return true;
    }
    constexpr double k_largest = std::numeric_limits<float>::max();
    if (std::isfinite(number) && std::abs(number) > k_largest) return false;
    store(at, static_cast<float>(number));
    return true;
  }
  if (!target.source.attribute) {
    store_whole(target.type, field.empty() ? least(target.type) : whole_of(column, field), at);
    return true;
  }
  if (field.empty()) {
    ++null_count_;
    store_whole(target.type, 0, at);
    return true;
  }
  const std::int64_t value = whole_of(column, field);
  if (value < 0 || static_cast<double>(value) > target.most) return false;
  store_whole(target.type, value, at);
  return true;
}

void CloudValues::reject(const Target& target, CopyField field, std::string location) {
  const NumberColumn& column = target.source.column;
  throw Error({}, std::move(location), fmt::format("{} out of range for the attribute", column.name),
              is_real(target.type) ? "a 32-bit integer" : fmt::format("0 to {}", target.most),
              fmt::format("{}", number_of(column, field)));
}

ServerCloud::ServerCloud(const ServerName& name) : connection_(name), table_(begin(connection_, name)) {}

ServerTable ServerCloud::begin(ServerConnection& connection, const ServerName& name) {
  connection.run("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
  // Numbers as text keep all bits; rows have one order; sorting uses more memory before the disk; conditions
  // on many rays are not compiled, which takes longer than evaluating them.
  connection.run(
      "SELECT set_config('extra_float_digits', '3', true), set_config('synchronize_seqscans', 'off', true),"
      " set_config('work_mem', '256MB', true), set_config('jit', 'off', true)");
  return find_server_table(connection, name);
}

void ServerCloud::read(const RowChoice& choice, const std::function<void(const ServerRow&)>& take,
                       const ServerWait& wait) {
  const NumberColumn coordinate{.name = "a coordinate", .type = ScalarType::float64};
  const NumberColumn id{.name = "id", .type = ScalarType::int64};
  ServerRow row;
  CopyDecoder decoder(k_first_value + choice.columns.size(), [&](std::span<const CopyField> fields) {
    for (int axis = 0; axis < static_cast<int>(k_axes); ++axis)
      row.world[axis] = number_of(coordinate, fields[static_cast<std::size_t>(axis)]);
    row.id = whole_of(id, fields[k_axes]);
    row.values = fields.subspan(k_first_value);
    take(row);
    ++row.number;
  });
  with_file(connection_.name(), [&] {
    connection_.copy_out(
        copy_statement(table_, choice), [&](auto bytes) { decoder.add(bytes); }, wait);
    decoder.finish();
  });
}

}  // namespace alidade::database
