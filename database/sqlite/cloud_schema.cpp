// SPDX-License-Identifier: MIT
#include "database/sqlite/cloud_schema.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "database/sqlite/connection.h"

namespace alidade::database {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers in blobs are copied as they are");

/// Whether a row of NAME_column is valid: the number lies within the bytes of a point.
bool is_possible(const StoredColumn& column) {
  const int type = static_cast<int>(column.type);
  if (type < static_cast<int>(ScalarType::bytes) || type > static_cast<int>(ScalarType::float64))
    return false;
  constexpr int k_most_bytes = 1 << 17;
  const int size = column.type == ScalarType::bytes ? column.size : scalar_size(column.type);
  return column.blob >= 0 && column.size > 0 && column.size < k_most_bytes && column.byte >= 0 &&
         column.byte <= column.size - size && std::isfinite(column.scale) && std::isfinite(column.offset);
}

template <class Values>
std::span<const std::byte> bytes_of(const Values& values) {
  return std::as_bytes(std::span(values));
}

/// The values of a blob; an incomplete one at the end is dropped.
template <class Values>
void take_bytes(std::span<const std::byte> bytes, Values& values) {
  values.resize(bytes.size() / sizeof values[0]);
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof values[0]);
}

/// Reads the schema of one cloud.
class SchemaReader {
 public:
  SchemaReader(sqlite3* database, const std::string& schema, const std::string& table)
      : database_(database), schema_(schema), table_(table) {}

  CloudSchema read() const {
    CloudSchema cloud;
    read_cloud(cloud);
    read_columns(cloud);
    return cloud;
  }

 private:
  [[noreturn]] void reject(const std::string& part, std::string problem, std::string expected,
                           std::string found) const {
    reject_stored({file_of(database_, schema_), fmt::format("table {}_{}", table_, part), std::move(problem),
                   std::move(expected), std::move(found)});
  }
  Statement statement(const std::string& part, const std::string& before, const std::string& behind) const {
    return {database_, before + part_name(schema_, table_, part) + behind, Readable::plain_tables, schema_};
  }
  void read_cloud(CloudSchema& cloud) const {
    Statement row = statement("cloud", "SELECT * FROM ", "");
    if (!row.step()) reject("cloud", "empty table", "one row", "");
    if (row.whole(0) != k_cloud_table_version) {
      reject("cloud", "unsupported version", std::to_string(k_cloud_table_version),
             std::to_string(row.whole(0)));
    }
    for (int axis = 0; axis < 3; ++axis) {
      cloud.lattice.scale[axis] = row.number(1 + axis);
      cloud.lattice.offset[axis] = row.number(4 + axis);
      if (!(cloud.lattice.scale[axis] > 0.0) || !std::isfinite(cloud.lattice.scale[axis]) ||
          !std::isfinite(cloud.lattice.offset[axis])) {
        reject("cloud", "invalid lattice", "positive scales and finite offsets",
               fmt::format("scale {}, offset {}", cloud.lattice.scale[axis], cloud.lattice.offset[axis]));
      }
    }
    // Every chunk has at least one point, and numbers of chunks have 32 bits.
    const std::int64_t points = row.whole(7), chunks = row.whole(8);
    if (row.type(7) != SQLITE_INTEGER || row.type(8) != SQLITE_INTEGER || chunks < 0 || chunks > UINT32_MAX ||
        points < chunks || points > chunks * k_most_chunk_points) {
      reject("cloud", "invalid counts",
             fmt::format("1 to {} points in each of 0 to {} chunks", k_most_chunk_points, UINT32_MAX),
             fmt::format("{} points in {} chunks", row.text(7), row.text(8)));
    }
    cloud.point_count = static_cast<std::uint64_t>(points);
    cloud.chunk_count = static_cast<std::uint64_t>(chunks);
    cloud.crs.wkt = row.text(9);
    take_bytes(row.bytes(10), cloud.crs.geotiff_keys);
    take_bytes(row.bytes(11), cloud.crs.geotiff_doubles);
    take_bytes(row.bytes(12), cloud.crs.geotiff_ascii);
    cloud.gps_time_is_standard = row.whole(13) != 0;
  }

  void read_columns(CloudSchema& cloud) const {
    Statement entry = statement(
        "column", "SELECT name, blob, size, place, type, scale, \"offset\", no_data FROM ", " ORDER BY id");
    while (entry.step()) {
      // Numbers out of range become -1, which is_possible() rejects.
      const auto small = [&](int index, std::int64_t most) {
        const std::int64_t number = entry.whole(index);
        return static_cast<int>(number >= 0 && number <= most ? number : -1);
      };
      StoredColumn column{.name = entry.text(0),
                          .blob = small(1, INT32_MAX),
                          .size = small(2, INT32_MAX),
                          .byte = small(3, INT32_MAX),
                          .type = static_cast<ScalarType>(small(4, static_cast<int>(ScalarType::float64))),
                          .scale = entry.number(5),
                          .offset = entry.number(6)};
      if (!entry.is_null(7)) {
        const std::span<const std::byte> mark = entry.bytes(7);
        if (mark.size() != column.no_data.emplace().size())
          reject("column", "invalid nodata value of column " + column.name, "8 bytes", "");
        std::memcpy(column.no_data->data(), mark.data(), mark.size());
      }
      const auto is_number = [&](int index) { return entry.type(index) == SQLITE_FLOAT; };
      if (entry.type(0) != SQLITE_TEXT || column.name.empty())
        reject("column", "column without a name", "", "");
      if (!is_possible(column) || !is_number(5) || !is_number(6))
        reject("column", "invalid column " + column.name, "an integer within the bytes of a point", "");
      cloud.columns.push_back(std::move(column));
    }
    if (cloud.columns.empty()) reject("column", "missing columns", "at least one", "none");
    check_blobs(cloud.columns);
    rename_earlier_columns(cloud.columns);
  }

  void check_blobs(const std::vector<StoredColumn>& columns) const {
    std::vector<const StoredColumn*> first_of(columns.size());
    for (const StoredColumn& column : columns) {
      const auto blob = static_cast<std::size_t>(column.blob);
      if (blob >= columns.size()) {
        reject("column", fmt::format("invalid blob of column {}", column.name),
               fmt::format("a number up to {}", columns.size() - 1), std::to_string(blob));
      }
      const StoredColumn*& first = first_of[blob];
      if (first == nullptr) first = &column;
      if (first->size != column.size) {
        reject("column",
               fmt::format("columns {} and {} state different sizes of one blob", first->name, column.name),
               std::to_string(first->size), std::to_string(column.size));
      }
    }
  }

  sqlite3* database_;
  const std::string &schema_, &table_;
};

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
  const auto& [scale, offset] = cloud.lattice;
  row.run_with(std::int64_t{k_cloud_table_version}, scale.x, scale.y, scale.z, offset.x, offset.y, offset.z,
               static_cast<std::int64_t>(cloud.point_count), static_cast<std::int64_t>(cloud.chunk_count),
               cloud.crs.wkt, bytes_of(cloud.crs.geotiff_keys), bytes_of(cloud.crs.geotiff_doubles),
               bytes_of(cloud.crs.geotiff_ascii), std::int64_t{cloud.gps_time_is_standard});

  run(database,
      "CREATE TABLE " + name("column") +
          "(id INTEGER PRIMARY KEY, name TEXT, blob INTEGER, size INTEGER, place INTEGER, type INTEGER,"
          " scale REAL, \"offset\" REAL, no_data BLOB)");
  Statement entry(database, "INSERT INTO " + name("column") + " VALUES(NULL,?,?,?,?,?,?,?,?)");
  for (const StoredColumn& column : cloud.columns) {
    entry.run_with(column.name, std::int64_t{column.blob}, std::int64_t{column.size},
                   std::int64_t{column.byte}, static_cast<std::int64_t>(column.type), column.scale,
                   column.offset, column.no_data ? bytes_of(*column.no_data) : std::span<const std::byte>());
  }
  run(database, "CREATE TABLE " + name("chunk") + "(id INTEGER PRIMARY KEY, points INTEGER, positions BLOB)");
  run(database, "CREATE TABLE " + name("value") + "(id INTEGER PRIMARY KEY, data BLOB)");
  run(database, "CREATE TABLE " + name("bounds") + "(id INTEGER PRIMARY KEY, boxes BLOB)");
}

CloudSchema read_cloud_schema(sqlite3* database, const std::string& schema, const std::string& table) {
  return SchemaReader(database, schema, table).read();
}

void drop_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table) {
  for (const char* const part : k_cloud_table_parts) {
    Statement found(database,
                    "SELECT type FROM " + sql_name(schema) +
                        ".sqlite_schema WHERE lower(name) = lower(?) AND type IN ('table', 'view')");
    if (!found.bind(1, table + "_" + part).step()) continue;
    const std::string type = found.text(0);
    found.reset();
    run(database, "DROP " + type + " " + part_name(schema, table, part));
  }
}

void rename_cloud_tables(sqlite3* database, const std::string& schema, const std::string& table,
                         const std::string& name) {
  for (const char* const part : k_cloud_table_parts) {
    run(database,
        "ALTER TABLE " + part_name(schema, table, part) + " RENAME TO " + sql_name(name + "_" + part));
  }
}

}  // namespace alidade::database
