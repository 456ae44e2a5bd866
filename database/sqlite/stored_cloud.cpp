// SPDX-License-Identifier: MIT
#include "database/sqlite/stored_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "base/bytes.h"
#include "cloud/point_cloud.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

bool is_attribute(const StoredBlob& blob, Attribute attribute) {
  const AttributeParts parts = attribute_parts(attribute);
  const int size = scalar_size(parts.type);
  if (blob.columns.size() != parts.names.size()) return false;
  for (std::size_t i = 0; i < parts.names.size(); ++i) {
    const StoredColumn& column = *blob.columns[i];
    const bool is_part = column.name == parts.names[i] && column.type == parts.type &&
                         column.place == size * static_cast<int>(i) &&
                         column.size == size * static_cast<int>(parts.names.size()) && column.scale == 1.0 &&
                         column.offset == 0.0 && !column.no_data;
    if (!is_part) return false;
  }
  return true;
}

/// Parts of a blob cannot be told from each other, unless they are those of an attribute.
bool is_dimension(const StoredBlob& blob) {
  const StoredColumn& column = *blob.columns.front();
  return blob.columns.size() == 1 && column.place == 0 &&
         (column.type == ScalarType::bytes || column.size == scalar_size(column.type));
}

/// All blobs but that of the ids, with columns that mean something.
std::vector<StoredBlob> blobs_of(const std::vector<StoredColumn>& columns) {
  std::vector<StoredBlob> blobs;
  for (std::size_t i = 1; i < columns.size(); ++i) {
    if (blobs.empty() || blobs.back().columns.back()->blob != columns[i].blob) blobs.emplace_back();
    blobs.back().columns.push_back(&columns[i]);
  }
  const PointCloud any;
  for_each_column(any, any, [&](Attribute attribute, const auto&, const auto&) {
    const auto found =
        std::ranges::find_if(blobs, [&](const StoredBlob& blob) { return is_attribute(blob, attribute); });
    if (found != blobs.end()) found->attribute = attribute;
  });
  return blobs;
}

ExtraDimension dimension_of(const StoredColumn& column) {
  ExtraDimension dimension;
  dimension.name = column.name;
  dimension.type = column.type;
  dimension.byte_count = column.size;
  dimension.scale = column.scale;
  dimension.offset = column.offset;
  dimension.has_scale = column.scale != 1.0;
  dimension.has_offset = column.offset != 0.0;
  dimension.no_data = column.no_data;
  return dimension;
}

/// The table's name, which may be left out where there is but one cloud.
std::string table_of(sqlite3* database, const SqliteCloudName& name) {
  Statement found(database,
                  "SELECT name FROM main.sqlite_schema WHERE type = 'table' AND"
                  " lower(sql) LIKE 'create virtual table%using pointcloud%' ORDER BY name");
  std::vector<std::string> tables;
  while (found.step()) tables.push_back(found.text(0));
  if (name.table.empty() && tables.size() == 1) return tables.front();
  if (!name.table.empty() && std::ranges::find(tables, name.table) != tables.end()) return name.table;
  throw Error({.file = name.file,
               .problem = name.table.empty() && !tables.empty()
                              ? "it is not said which cloud of the database is meant"
                          : name.table.empty() ? "the database holds no cloud"
                                               : fmt::format("the database holds no cloud {}", name.table),
               .expected = tables.empty() ? "a database that 'alidade sql load' wrote"
                                          : fmt::format("{}?table=NAME", name.file),
               .found = fmt::format("{}", fmt::join(tables, ", "))});
}

}  // namespace

SqliteCloudName::SqliteCloudName(const std::string& name) : file(name) {
  const std::size_t mark = name.rfind(k_table_word);
  if (mark == std::string::npos) return;
  file = name.substr(0, mark);
  table = name.substr(mark + k_table_word.size());
}

StoredCloud::StoredCloud(const std::string& name)
    : name_(name),
      connection_(name_.file, Connection::Mode::read),
      table_(table_of(connection_.get(), name_)),
      schema_(read_cloud_schema(connection_.get(), k_schema, table_)),
      blobs_(blobs_of(schema_.columns)),
      file_bytes_(std::filesystem::file_size(name_.file)) {
  const StoredColumn& ids = schema_.columns.front();
  if (ids.type != ScalarType::uint64 || ids.size != scalar_size(ids.type) || ids.place != 0) {
    throw Error({.file = name_.file,
                 .place = fmt::format("table {}_column", table_),
                 .problem = "the first column holds no ids",
                 .expected = "numbers of 8 bytes"});
  }
  for (const StoredBlob& blob : blobs_) {
    if (!blob.attribute && is_dimension(blob)) dimensions_.push_back(blob.columns.front());
  }
  if (schema_.point_count > file_bytes_ / sizeof(LatticePosition)) {
    throw Error({.file = name_.file,
                 .place = fmt::format("table {}_cloud", table_),
                 .problem = "counts more points than the file has room for",
                 .expected = fmt::format("at most {}", file_bytes_ / sizeof(LatticePosition)),
                 .found = std::to_string(schema_.point_count)});
  }
}

AttributeSet StoredCloud::attributes() const {
  AttributeSet all;
  for (const StoredBlob& blob : blobs_) {
    if (blob.attribute) all = all | *blob.attribute;
  }
  return dimensions_.empty() ? all : all | Attribute::extra_dimensions;
}

Bounds StoredCloud::bounds() const {
  Bounds box;
  BoxTree(connection_.get(), k_schema, table_, schema_.chunk_count).chunks([&](const Bounds& part) {
    box.grow(part);
    return false;
  });
  return box;
}

std::uint64_t StoredCloud::id(ChunkStore& store, StoredChunk& chunk, std::size_t i) const {
  const auto number = load<std::uint64_t>(store.bytes(chunk, schema_.columns.front(), i));
  if (number >= schema_.point_count) {
    refuse(chunk.id, "ids are not the rows of the points",
           fmt::format("each number below {} once", schema_.point_count), std::to_string(number));
  }
  return number;
}

void StoredCloud::refuse(std::uint64_t chunk, std::string problem, std::string expected,
                         std::string found) const {
  throw Error({.file = name_.file,
               .place = fmt::format("table {}, chunk {}", table_, chunk),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

StoredCloud::Columns::Columns(const StoredCloud& stored, PointCloud& cloud, AttributeSet kept,
                              std::size_t first_row) {
  for_each_column(cloud, cloud, [&](Attribute attribute, auto& column, const auto&) {
    const auto blob = std::ranges::find(stored.blobs_, attribute, &StoredBlob::attribute);
    if (!kept.contains(attribute) || blob == stored.blobs_.end()) return;
    targets_.push_back({blob->columns.front(), reinterpret_cast<std::byte*>(column.data() + first_row),
                        sizeof column.front()});
  });
  if (!kept.contains(Attribute::extra_dimensions)) return;
  for (const StoredColumn* const column : stored.dimensions_) {
    const std::size_t place = find_extra_dimension(cloud, dimension_of(*column));
    const auto size = static_cast<std::size_t>(column->size);
    targets_.push_back(
        {column, reinterpret_cast<std::byte*>(cloud.extra_dimensions[place].values.data()) + first_row * size,
         size});
  }
}

void StoredCloud::Columns::copy(ChunkStore& store, StoredChunk& chunk, std::size_t i, std::size_t row) const {
  for (const Target& target : targets_) {
    const std::byte* const value = store.bytes(chunk, *target.column, i) - target.column->place;
    std::memcpy(target.values + row * target.size, value, target.size);
  }
}

}  // namespace alidade
