// SPDX-License-Identifier: MIT
#include "extensions/postgres/server_table.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "base/error.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"
#include "database/sql/sql_tokens.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

constexpr std::int64_t k_numeric = 1700;

/// PostgreSQL's numbers of its types, which are the same everywhere, and their names in SQL.
constexpr struct NumberType {
  std::int64_t number;
  ScalarType type;
  const char* name;
} k_number_types[] = {{21, ScalarType::int16, "int2"},      {23, ScalarType::int32, "int4"},
                      {20, ScalarType::int64, "int8"},      {700, ScalarType::float32, "float4"},
                      {701, ScalarType::float64, "float8"}, {k_numeric, ScalarType::float64, "float8"}};

/// A list of names for a message, of limited length.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t k_most = 12;
  const std::size_t count = std::min(names.size(), k_most);
  return fmt::format("{}{}",
                     fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count), ", "),
                     names.size() > count ? ", ..." : "");
}

/// Number, schema, name and estimated rows of the table.
ServerRows find_relation(ServerConnection& connection, const ServerName& name) {
  const std::array<std::string, 2> names = {name.table, name.schema};
  ServerRows found = connection.run(
      "SELECT c.oid, n.nspname, c.relname, c.reltuples FROM pg_catalog.pg_class c"
      " JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace"
      " WHERE c.relname::text = $1::text AND c.relkind IN ('r', 'v', 'm', 'f', 'p')"
      " AND CASE WHEN $2::text = '' THEN pg_catalog.pg_table_is_visible(c.oid) ELSE n.nspname::text = "
      "$2::text END",
      names);
  if (found.size() > 0) return found;
  const ServerRows others = connection.run(
      "SELECT c.relname FROM pg_catalog.pg_class c WHERE c.relkind IN ('r', 'v', 'm', 'f', 'p')"
      " AND pg_catalog.pg_table_is_visible(c.oid) AND 3 = (SELECT count(*) FROM pg_catalog.pg_attribute a"
      " WHERE a.attrelid = c.oid AND a.attnum > 0 AND a.attname IN ('x', 'y', 'z')) ORDER BY c.relname LIMIT "
      "13");
  std::vector<std::string> tables;
  for (std::size_t i = 0; i < others.size(); ++i) tables.push_back(others.text(i, 0));
  const std::string known = listed(tables);
  if (name.table.empty()) connection.fail("ambiguous table", "postgresql://HOST/DATABASE?table=NAME", known);
  connection.fail("unknown table", name.schema.empty() ? "" : "one in schema " + name.schema,
                  known.empty() ? "no table with x, y and z" : known);
}

void read_columns(ServerConnection& connection, const std::string& number, ServerTable& table) {
  // Domains are read as their base types.
  const ServerRows rows = connection.run(
      "SELECT a.attname, COALESCE(NULLIF(t.typbasetype, 0), t.oid)::int8, NOT a.attnotnull"
      " FROM pg_catalog.pg_attribute a JOIN pg_catalog.pg_type t ON t.oid = a.atttypid"
      " WHERE a.attrelid = $1::oid AND a.attnum > 0 AND NOT a.attisdropped ORDER BY a.attnum",
      std::span(&number, 1));
  std::vector<std::string> all;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::int64_t type = rows.whole(i, 1);
    all.push_back(rows.text(i, 0));
    const auto known = std::ranges::find(k_number_types, type, &NumberType::number);
    if (known != std::end(k_number_types)) {
      table.columns.push_back({.name = all.back(),
                               .type = known->type,
                               .is_decimal = type == k_numeric,
                               .can_be_null = rows.text(i, 2) == "t"});
    } else {
      table.left_out.push_back(all.back());
    }
  }
  for (const char* const axis : {"x", "y", "z"}) {
    if (table.find(axis) == nullptr)
      connection.fail(fmt::format("missing numeric column {}", axis), "x, y and z", listed(all));
  }
}

/// Bytes in hexadecimal digits, as whole values.
template <class Values>
void take_hex(const std::string& text, Values& values) {
  std::vector<unsigned char> bytes(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    std::from_chars(text.data() + 2 * i, text.data() + 2 * i + 2, bytes[i], 16);
  values.resize(bytes.size() / sizeof values[0]);
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof values[0]);
}

/// Whether the table of that name in the schema has the columns of cloud_row_table().
bool is_cloud_row_table(ServerConnection& connection, const std::string& schema, const std::string& name) {
  const std::array<std::string, 2> names = {schema, name};
  const ServerRows rows = connection.run(
      "SELECT count(*) FROM pg_catalog.pg_attribute a JOIN pg_catalog.pg_class c ON c.oid = a.attrelid"
      " JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace"
      " WHERE n.nspname::text = $1::text AND c.relname::text = $2::text AND c.relkind = 'r'"
      " AND a.attname IN ('version', 'scale_x', 'points', 'max_z', 'crs', 'geotiff_ascii',"
      " 'gps_time_is_standard')",
      names);
  return rows.whole(0, 0) == 7;
}

CloudRow read_cloud_row(ServerConnection& connection, const std::string& schema, const std::string& name) {
  const ServerRows rows = connection.run(
      "SELECT version, scale_x, scale_y, scale_z, offset_x, offset_y, offset_z, points, crs,"
      " min_x, min_y, min_z, max_x, max_y, max_z, encode(geotiff_keys, 'hex'), encode(geotiff_doubles, "
      "'hex'), encode(geotiff_ascii, 'hex'),"
      " gps_time_is_standard FROM " +
      sql_name(schema) + "." + sql_name(name) + " LIMIT 2");
  const auto reject = [&](std::string problem, std::string expected, std::string found) {
    connection.fail(std::move(problem), std::move(expected), std::move(found), "table " + name);
  };
  if (rows.size() != 1) reject("wrong number of rows", "one row", rows.size() == 0 ? "none" : "several");
  if (rows.whole(0, 0) != k_cloud_row_version)
    reject("unsupported version", std::to_string(k_cloud_row_version), rows.text(0, 0));
  CloudRow row;
  for (int axis = 0; axis < 3; ++axis) {
    row.lattice.scale[axis] = rows.number(0, 1 + axis);
    row.lattice.offset[axis] = rows.number(0, 4 + axis);
    const bool is_possible = std::isnormal(row.lattice.scale[axis]) && row.lattice.scale[axis] > 0.0 &&
                             std::isfinite(row.lattice.offset[axis]);
    if (!is_possible) {
      reject("invalid lattice", "positive scales and finite offsets",
             fmt::format("{} and {}", rows.text(0, 1 + axis), rows.text(0, 4 + axis)));
    }
  }
  const std::int64_t points = rows.whole(0, 7);
  if (points < 0) reject("negative number of points", {}, rows.text(0, 7));
  row.point_count = static_cast<std::uint64_t>(points);
  row.crs.wkt = rows.text(0, 8);
  for (int axis = 0; axis < 3 && !rows.is_null(0, 9); ++axis) {
    row.box.min[axis] = rows.number(0, 9 + axis);
    row.box.max[axis] = rows.number(0, 12 + axis);
  }
  take_hex(rows.text(0, 15), row.crs.geotiff_keys);
  take_hex(rows.text(0, 16), row.crs.geotiff_doubles);
  take_hex(rows.text(0, 17), row.crs.geotiff_ascii);
  row.gps_time_is_standard = rows.text(0, 18) == "t";
  return row;
}

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

std::string NumberColumn::expression() const {
  // The value of a domain is sent as that of its base type.
  return sql_name(name) + "::" + std::ranges::find(k_number_types, type, &NumberType::type)->name;
}

const NumberColumn* ServerTable::find(std::string_view name) const {
  const auto found = std::ranges::find(columns, name, &NumberColumn::name);
  return found == columns.end() ? nullptr : &*found;
}

std::string ServerTable::has_position() const {
  // PostgreSQL puts NaN above all numbers, and NULL is never greater or less.
  return "x > '-Infinity'::float8 AND x < 'Infinity'::float8 AND y > '-Infinity'::float8 AND"
         " y < 'Infinity'::float8 AND z > '-Infinity'::float8 AND z < 'Infinity'::float8";
}

ServerTable find_server_table(ServerConnection& connection, const ServerName& name) {
  const ServerRows relation = find_relation(connection, name);
  const std::string schema = relation.text(0, 1), table_name = relation.text(0, 2);
  ServerTable table;
  table.quoted_name = sql_name(schema) + "." + sql_name(table_name);
  table.row_estimate = std::max(relation.number(0, 3), 0.0);
  read_columns(connection, relation.text(0, 0), table);
  const std::string cloud_name = table_name + "_cloud";
  if (is_cloud_row_table(connection, schema, cloud_name))
    table.cloud = read_cloud_row(connection, schema, cloud_name);
  return table;
}

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
