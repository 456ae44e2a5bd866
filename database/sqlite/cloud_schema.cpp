// SPDX-License-Identifier: MIT
#include "database/sqlite/cloud_schema.h"

#include <fmt/format.h>

#include <cmath>

#include "database/sqlite/statement.h"

namespace alidade {
namespace {

const char* const k_parts[] = {"cloud", "column", "chunk", "value", "bounds"};

[[noreturn]] void refuse(const std::string& table, const std::string& part, std::string problem,
                         std::string expected, std::string found) {
  throw Error({.file = table,
               .place = fmt::format("table {}_{}", table, part),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

/// Whether a row of NAME_column can be: the number lies within the bytes of a point.
bool is_possible(const StoredColumn& column) {
  const int type = static_cast<int>(column.type);
  if (type < static_cast<int>(ScalarType::bytes) || type > static_cast<int>(ScalarType::float64))
    return false;
  constexpr int k_most_blobs = 1 << 20, k_most_bytes = 1 << 17;
  const int size = column.type == ScalarType::bytes ? column.size : scalar_size(column.type);
  return column.blob >= 0 && column.blob < k_most_blobs && column.size > 0 && column.size < k_most_bytes &&
         column.place >= 0 && column.place <= column.size - size;
}

/// Whole values only.
template <class Values>
void take_bytes(std::span<const std::byte> bytes, Values& values) {
  values.resize(bytes.size() / sizeof values[0]);
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof values[0]);
}

}  // namespace

std::string part_name(const std::string& schema, const std::string& table, const std::string& part) {
  return sql_name(schema) + "." + sql_name(table + "_" + part);
}

void create_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table,
                         const CloudSchema& cloud) {
  const auto name = [&](const char* part) { return part_name(schema, table, part); };
  run(database,
      "CREATE TABLE " + name("cloud") +
          "(version INTEGER, scale_x REAL, scale_y REAL, scale_z REAL, offset_x REAL, offset_y REAL,"
          " offset_z REAL, points INTEGER, chunks INTEGER, crs TEXT,"
          " geotiff_keys BLOB, geotiff_doubles BLOB, geotiff_ascii BLOB, gps_time_is_standard INTEGER)");
  Statement row(database, "INSERT INTO " + name("cloud") + " VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  row.bind(1, std::int64_t{k_cloud_table_version});
  for (int axis = 0; axis < 3; ++axis) {
    row.bind(2 + axis, cloud.lattice.scale[axis]);
    row.bind(5 + axis, cloud.lattice.offset[axis]);
  }
  row.bind(8, static_cast<std::int64_t>(cloud.point_count));
  row.bind(9, static_cast<std::int64_t>(cloud.chunk_count));
  row.bind(10, cloud.crs.wkt);
  row.bind(11, std::as_bytes(std::span(cloud.crs.geotiff_keys)));
  row.bind(12, std::as_bytes(std::span(cloud.crs.geotiff_doubles)));
  row.bind(13, std::as_bytes(std::span(cloud.crs.geotiff_ascii)));
  row.bind(14, std::int64_t{cloud.gps_time_is_standard});
  row.run();

  run(database,
      "CREATE TABLE " + name("column") +
          "(id INTEGER PRIMARY KEY, name TEXT, blob INTEGER, size INTEGER, place INTEGER, type INTEGER,"
          " scale REAL, \"offset\" REAL, no_data REAL)");
  Statement entry(database, "INSERT INTO " + name("column") + " VALUES(NULL,?,?,?,?,?,?,?,?)");
  for (const StoredColumn& column : cloud.columns) {
    entry.bind(1, column.name);
    entry.bind(2, std::int64_t{column.blob});
    entry.bind(3, std::int64_t{column.size});
    entry.bind(4, std::int64_t{column.place});
    entry.bind(5, static_cast<std::int64_t>(column.type));
    entry.bind(6, column.scale);
    entry.bind(7, column.offset);
    if (column.no_data)
      entry.bind(8, *column.no_data);
    else
      entry.bind_null(8);
    entry.run();
  }
  run(database, "CREATE TABLE " + name("chunk") + "(id INTEGER PRIMARY KEY, points INTEGER, positions BLOB)");
  run(database, "CREATE TABLE " + name("value") + "(id INTEGER PRIMARY KEY, data BLOB)");
  run(database, "CREATE TABLE " + name("bounds") + "(id INTEGER PRIMARY KEY, boxes BLOB)");
}

CloudSchema read_cloud_schema(sqlite3* database, const std::string& schema, const std::string& table) {
  CloudSchema cloud;
  Statement row(database, "SELECT * FROM " + part_name(schema, table, "cloud"));
  if (!row.step()) refuse(table, "cloud", "is empty", "one row", "");
  if (row.whole(0) != k_cloud_table_version) {
    refuse(table, "cloud", "is of another version", std::to_string(k_cloud_table_version),
           std::to_string(row.whole(0)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    cloud.lattice.scale[axis] = row.number(1 + axis);
    cloud.lattice.offset[axis] = row.number(4 + axis);
    if (!(cloud.lattice.scale[axis] > 0.0) || !std::isfinite(cloud.lattice.scale[axis]) ||
        !std::isfinite(cloud.lattice.offset[axis])) {
      refuse(table, "cloud", "has no lattice", "a scale above 0 and finite offsets",
             fmt::format("scale {}, offset {}", cloud.lattice.scale[axis], cloud.lattice.offset[axis]));
    }
  }
  if (row.whole(7) < 0 || row.whole(8) < 0) {
    refuse(table, "cloud", "counts fewer than no points", "counts from 0",
           fmt::format("{} points in {} chunks", row.whole(7), row.whole(8)));
  }
  cloud.point_count = static_cast<std::uint64_t>(row.whole(7));
  cloud.chunk_count = static_cast<std::uint64_t>(row.whole(8));
  cloud.crs.wkt = row.text(9);
  take_bytes(row.bytes(10), cloud.crs.geotiff_keys);
  take_bytes(row.bytes(11), cloud.crs.geotiff_doubles);
  take_bytes(row.bytes(12), cloud.crs.geotiff_ascii);
  cloud.gps_time_is_standard = row.whole(13) != 0;
  Statement entry(database, "SELECT name, blob, size, place, type, scale, \"offset\", no_data FROM " +
                                part_name(schema, table, "column") + " ORDER BY id");
  while (entry.step()) {
    StoredColumn column{.name = entry.text(0),
                        .blob = static_cast<int>(entry.whole(1)),
                        .size = static_cast<int>(entry.whole(2)),
                        .place = static_cast<int>(entry.whole(3)),
                        .type = static_cast<ScalarType>(entry.whole(4)),
                        .scale = entry.number(5),
                        .offset = entry.number(6)};
    if (!entry.is_null(7)) column.no_data = entry.number(7);
    if (!is_possible(column))
      refuse(table, "column", "describes a column that cannot be", "a number within a point's bytes",
             column.name);
    cloud.columns.push_back(std::move(column));
  }
  if (cloud.columns.empty()) refuse(table, "column", "describes no columns", "one or more", "none");
  return cloud;
}

void drop_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table) {
  for (const char* const part : k_parts)
    run(database, "DROP TABLE IF EXISTS " + part_name(schema, table, part));
}

}  // namespace alidade
