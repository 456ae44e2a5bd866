// SPDX-License-Identifier: MIT
#include "database/server/server_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>

#include "database/sql_name.h"

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

}  // namespace alidade::database
