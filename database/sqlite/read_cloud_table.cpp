// SPDX-License-Identifier: MIT
#include "database/sqlite/read_cloud_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>

#include "database/sqlite/chunk_store.h"
#include "database/sqlite/connection.h"
#include "octree/cloud/append_rows.h"
#include "octree/cloud/attribute_columns.h"
#include "octree/cloud/byte_order.h"
#include "octree/cloud/lattice_shift.h"

namespace alidade {
namespace {

constexpr std::string_view k_table_word = "?table=";
constexpr std::string_view k_first_bytes{"SQLite format 3\0", 16};

/// The columns of one blob, by their places.
struct Blob {
  std::vector<const StoredColumn*> columns;
  std::optional<Attribute> attribute{};  ///< none: an extra dimension
};

bool is_attribute(const Blob& blob, Attribute attribute) {
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
bool is_dimension(const Blob& blob) {
  const StoredColumn& column = *blob.columns.front();
  return blob.columns.size() == 1 && column.place == 0 &&
         (column.type == ScalarType::bytes || column.size == scalar_size(column.type));
}

/// All blobs but that of the ids, with columns that mean something.
std::vector<Blob> blobs_of(const std::vector<StoredColumn>& columns) {
  std::vector<Blob> blobs;
  for (std::size_t i = 1; i < columns.size(); ++i) {
    if (blobs.empty() || blobs.back().columns.back()->blob != columns[i].blob) blobs.emplace_back();
    blobs.back().columns.push_back(&columns[i]);
  }
  const PointCloud any;
  for_each_column(any, any, [&](Attribute attribute, const auto&, const auto&) {
    const auto found =
        std::ranges::find_if(blobs, [&](const Blob& blob) { return is_attribute(blob, attribute); });
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

class SqliteCloudReader final : public CloudReader {
 public:
  explicit SqliteCloudReader(const std::string& name)
      : name_(name),
        connection_(name_.file, Connection::Mode::read),
        table_(table_of(connection_.get(), name_)),
        schema_(read_cloud_schema(connection_.get(), k_schema, table_)),
        blobs_(blobs_of(schema_.columns)),
        file_bytes_(std::filesystem::file_size(name_.file)) {
    about_.path = name;
    about_.format = "SQLite";
    about_.version = std::to_string(k_cloud_table_version);
    about_.point_count = schema_.point_count;
    const StoredColumn& ids = schema_.columns.front();
    if (ids.type != ScalarType::uint64 || ids.size != scalar_size(ids.type) || ids.place != 0) {
      throw Error({.file = name_.file,
                   .place = fmt::format("table {}_column", table_),
                   .problem = "the first column holds no ids",
                   .expected = "numbers of 8 bytes"});
    }
    for (const Blob& blob : blobs_) {
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

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override;
  FileFacts facts() const override;
  std::optional<Lattice> lattice() const override { return schema_.lattice; }
  std::optional<std::uint64_t> point_count() const override { return schema_.point_count; }
  CoordinateSurvey survey(const Progress&) override {
    // The lattice is stored: there is nothing to find out.
    return {};
  }
  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override;

 private:
  static constexpr const char* k_schema = "main";

  /// Where values of a blob go: `size` bytes per point.
  struct Target {
    const StoredColumn* column;  ///< a column of the blob
    std::byte* values;           ///< of the first of the rows
    std::size_t size;
  };
  /// Rows [first, first + count) of the table, which are rows from `target` on of the cloud.
  struct Rows {
    std::uint64_t first;
    std::size_t count, target;
  };

  std::vector<Target> targets(PointCloud& cloud, AttributeSet kept, const Rows& rows) const;
  void take_rows(PointCloud& cloud, AttributeSet kept, const Rows& rows,
                 const std::function<void(double share)>& tell);
  [[noreturn]] void refuse(std::uint64_t chunk, std::string problem, std::string expected,
                           std::string found) const;

  SqliteCloudName name_;
  Connection connection_;
  std::string table_;
  CloudSchema schema_;
  std::vector<Blob> blobs_;
  std::vector<const StoredColumn*> dimensions_;
  std::uint64_t file_bytes_;
  CloudFile about_;
};

AttributeSet SqliteCloudReader::attributes() const {
  AttributeSet all;
  for (const Blob& blob : blobs_) {
    if (blob.attribute) all = all | *blob.attribute;
  }
  return dimensions_.empty() ? all : all | Attribute::extra_dimensions;
}

FileFacts SqliteCloudReader::facts() const {
  FileFacts facts;
  facts.crs = schema_.crs;
  facts.gps_time_is_standard = schema_.gps_time_is_standard;
  Bounds box;
  BoxTree(connection_.get(), k_schema, table_, schema_.chunk_count).chunks([&](const Bounds& part) {
    box.grow(part);
    return false;
  });
  if (schema_.point_count > 0) facts.box = box;
  return facts;
}

/// Where the values of these rows go, in columns that are there.
std::vector<SqliteCloudReader::Target> SqliteCloudReader::targets(PointCloud& cloud, AttributeSet kept,
                                                                  const Rows& rows) const {
  std::vector<Target> all;
  for_each_column(cloud, cloud, [&](Attribute attribute, auto& column, const auto&) {
    if (!kept.contains(attribute)) return;
    const auto blob = std::ranges::find(blobs_, attribute, &Blob::attribute);
    all.push_back({blob->columns.front(), reinterpret_cast<std::byte*>(column.data() + rows.target),
                   sizeof column.front()});
  });
  if (!kept.contains(Attribute::extra_dimensions)) return all;
  for (const StoredColumn* const column : dimensions_) {
    const std::size_t place = find_extra_dimension(cloud, dimension_of(*column));
    const auto size = static_cast<std::size_t>(column->size);
    all.push_back(
        {column,
         reinterpret_cast<std::byte*>(cloud.extra_dimensions[place].values.data()) + rows.target * size,
         size});
  }
  return all;
}

void SqliteCloudReader::refuse(std::uint64_t chunk, std::string problem, std::string expected,
                               std::string found) const {
  throw Error({.file = name_.file,
               .place = fmt::format("table {}, chunk {}", table_, chunk),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

/// Chunks lie along a curve, not in the order of rows: each piece is a pass over all of them.
void SqliteCloudReader::take_rows(PointCloud& cloud, AttributeSet kept, const Rows& rows,
                                  const std::function<void(double share)>& tell) {
  const LatticeShift shift(schema_.lattice, cloud.lattice, name_.file);
  const std::vector<Target> columns = targets(cloud, kept, rows);
  ChunkStore store(connection_.get(), k_schema, table_, schema_);
  std::vector<bool> is_there(rows.count);
  std::uint64_t points = 0;
  std::size_t taken = 0;
  for (const ChunkPlace& place : store.chunks({}, {}, std::nullopt)) {
    const std::uint64_t id = place.id;
    const std::shared_ptr<StoredChunk> chunk = store.read(place);
    for (std::size_t i = 0; i < chunk->positions.size(); ++i) {
      const auto number = load<std::uint64_t>(store.bytes(*chunk, schema_.columns.front(), i));
      const std::uint64_t row = number - rows.first;
      if (number < schema_.point_count && row >= rows.count) continue;
      if (number >= schema_.point_count || is_there[row]) {
        refuse(id, "ids are not the rows of the points",
               fmt::format("each number below {} once", schema_.point_count), std::to_string(number));
      }
      is_there[row] = true;
      ++taken;
      cloud.positions[rows.target + row] = shift(chunk->positions[i]);
      for (const Target& column : columns) {
        const std::byte* const value = store.bytes(*chunk, *column.column, i) - column.column->place;
        std::memcpy(column.values + row * column.size, value, column.size);
      }
    }
    points += chunk->positions.size();
    tell(static_cast<double>(id + 1) / static_cast<double>(schema_.chunk_count));
  }
  if (points != schema_.point_count || taken != rows.count) {
    refuse(schema_.chunk_count, "points are missing", std::to_string(schema_.point_count),
           std::to_string(points));
  }
}

void SqliteCloudReader::read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                                       const Progress& progress) {
  const AttributeSet kept = attributes() & wanted;
  const auto bytes = static_cast<double>(file_bytes_);
  for (std::uint64_t row = 0; row < schema_.point_count;) {
    const std::size_t count = room_in_piece(cloud, kept, schema_.point_count - row, pieces);
    const Rows rows{row, count, cloud.size()};
    append_rows(cloud, kept, count);
    const auto share = [&](std::uint64_t rows_done) {
      return static_cast<double>(rows_done) / static_cast<double>(schema_.point_count);
    };
    take_rows(cloud, kept, rows, [&](double part) {
      report(progress, static_cast<std::uint64_t>(bytes * (share(row) + part * share(count))), file_bytes_);
    });
    row += count;
  }
  report(progress, file_bytes_, file_bytes_);
}

bool is_named(const std::string& name) {
  return name.find(k_table_word) != std::string::npos;
}

}  // namespace

SqliteCloudName::SqliteCloudName(const std::string& name) : file(name) {
  const std::size_t mark = name.rfind(k_table_word);
  if (mark == std::string::npos) return;
  file = name.substr(0, mark);
  table = name.substr(mark + k_table_word.size());
}

CloudDatabase sqlite_clouds() {
  return {.is_named = [](const std::string& name) { return is_named(name) && !name.starts_with("postgres"); },
          .is_begun_by = [](const std::string& bytes) { return bytes.starts_with(k_first_bytes); },
          .open = [](const std::string& name) -> std::unique_ptr<CloudReader> {
            return std::make_unique<SqliteCloudReader>(name);
          }};
}

}  // namespace alidade
