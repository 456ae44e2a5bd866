// SPDX-License-Identifier: MIT
#include "database/sqlite/stored_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"
#include "cloud/rows.h"
#include "database/sqlite/chunk_store.h"
#include "database/sqlite/connection.h"

namespace alidade::database {
namespace {

constexpr std::string_view k_table_word = "?table=";

/// The parts of a cloud's name.
struct SqliteCloudName {
  std::string file, table;

  explicit SqliteCloudName(const std::string& name) : file(name) {
    const std::size_t mark = name.rfind(k_table_word);
    if (mark == std::string::npos) return;
    file = name.substr(0, mark);
    table = name.substr(mark + k_table_word.size());
  }
};

/// The columns of one blob, in the order of their bytes.
struct StoredBlob {
  std::vector<const StoredColumn*> columns;
  std::optional<Attribute> attribute{};  ///< empty: an extra dimension, or something else
};

bool is_attribute(const StoredBlob& blob, Attribute attribute) {
  const AttributeParts parts = attribute_parts(attribute);
  const int size = scalar_size(parts.type);
  if (blob.columns.size() != parts.names.size()) return false;
  for (std::size_t i = 0; i < parts.names.size(); ++i) {
    const StoredColumn& column = *blob.columns[i];
    const bool is_part = column.name == parts.names[i] && column.type == parts.type &&
                         column.byte == size * static_cast<int>(i) &&
                         column.size == size * static_cast<int>(parts.names.size()) && column.scale == 1.0 &&
                         column.offset == 0.0 && !column.no_data;
    if (!is_part) return false;
  }
  return true;
}

/// Whether a blob is an extra dimension: it has a single column, since several are only distinguished if they
/// are those of an attribute.
bool is_dimension(const StoredBlob& blob) {
  const StoredColumn& column = *blob.columns.front();
  return blob.columns.size() == 1 && column.byte == 0 &&
         (column.type == ScalarType::bytes || column.size == scalar_size(column.type));
}

/// All blobs but that of the ids, with the attributes that they are.
std::vector<StoredBlob> blobs_of(const std::vector<StoredColumn>& columns) {
  std::vector<StoredBlob> blobs;
  for (std::size_t i = 1; i < columns.size(); ++i) {
    if (blobs.empty() || blobs.back().columns.back()->blob != columns[i].blob) blobs.emplace_back();
    blobs.back().columns.push_back(&columns[i]);
  }
  const PointCloud any;
  for_each_column(any, [&](Attribute attribute, const auto&) {
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

/// The table's name, which may be omitted if there is only one cloud.
std::string table_of(sqlite3* database, const SqliteCloudName& name) {
  Statement found(database,
                  "SELECT name FROM main.sqlite_schema WHERE type = 'table' AND"
                  " lower(sql) LIKE 'create virtual table%using pointcloud%' ORDER BY name");
  std::vector<std::string> tables;
  while (found.step()) tables.push_back(found.text(0));
  if (name.table.empty() && tables.size() == 1) return tables.front();
  if (!name.table.empty() && std::ranges::find(tables, name.table) != tables.end()) return name.table;
  throw Error({.file = name.file,
               .problem = name.table.empty() && !tables.empty() ? "ambiguous cloud: the database has several"
                          : name.table.empty()                  ? "the database contains no cloud"
                                               : fmt::format("the database contains no cloud {}", name.table),
               .expected = tables.empty() ? "a database written by 'alidade sql load'"
                                          : fmt::format("{}?table=NAME", name.file),
               .found = fmt::format("{}", fmt::join(tables, ", "))});
}

/// A cloud in a file, open for reading.
class StoredCloud {
 public:
  explicit StoredCloud(const std::string& name)
      : name_(name),
        connection_(name_.file, Connection::Mode::read),
        table_(table_of(connection_.get(), name_)),
        schema_(read_cloud_schema(connection_.get(), k_schema, table_)),
        blobs_(blobs_of(schema_.columns)),
        file_bytes_(std::filesystem::file_size(name_.file)) {
    const StoredColumn& ids = schema_.columns.front();
    if (ids.type != ScalarType::uint64 || ids.size != scalar_size(ids.type) || ids.byte != 0)
      reject("_column", "the first column has no ids", "8-byte integers", "");
    for (const StoredBlob& blob : blobs_) {
      if (!blob.attribute && is_dimension(blob)) dimensions_.push_back(blob.columns.front());
    }
    const std::uint64_t most = file_bytes_ / sizeof(LatticePosition);
    if (schema_.point_count > most) {
      reject("_cloud", "the number of points exceeds the file", fmt::format("at most {}", most),
             std::to_string(schema_.point_count));
    }
  }

  const std::string& file() const { return name_.file; }
  const CloudSchema& schema() const { return schema_; }
  std::uint64_t file_bytes() const { return file_bytes_; }
  ChunkStore chunks() const { return {connection_.get(), k_schema, table_, schema_}; }

  /// Attributes that the cloud has as a PointCloud.
  AttributeSet attributes() const {
    AttributeSet all;
    for (const StoredBlob& blob : blobs_) {
      if (blob.attribute) all = all | *blob.attribute;
    }
    return dimensions_.empty() ? all : all | Attribute::extra_dimensions;
  }

  /// Bounds of all points, from the boxes of the chunks; empty without chunks.
  Bounds bounds() const {
    Bounds box;
    BoxTree(connection_.get(), k_schema, table_, schema_.chunk_count).chunks([&](const Bounds& part) {
      box.grow(part);
      return false;
    });
    return box;
  }

  /// Copies attributes of stored points into rows of a cloud.
  class Columns {
   public:
    /// `kept`: of attributes(); requires that the cloud has columns for all of them. `first_row`: the cloud's
    /// row for row 0.
    Columns(const StoredCloud& stored, PointCloud& cloud, AttributeSet kept, std::size_t first_row) {
      for_each_column(cloud, [&](Attribute attribute, auto& column) {
        const auto blob = std::ranges::find(stored.blobs_, attribute, &StoredBlob::attribute);
        if (!kept.contains(attribute) || blob == stored.blobs_.end()) return;
        targets_.push_back({blob->columns.front(), reinterpret_cast<std::byte*>(column.data() + first_row),
                            sizeof column.front()});
      });
      if (!kept.contains(Attribute::extra_dimensions)) return;
      for (const StoredColumn* const column : stored.dimensions_) {
        std::vector<std::uint8_t>& values =
            cloud.extra_dimensions[find_extra_dimension(cloud, dimension_of(*column))].values;
        const auto size = static_cast<std::size_t>(column->size);
        targets_.push_back({column, reinterpret_cast<std::byte*>(values.data()) + first_row * size, size});
      }
    }

    /// Errors: ChunkStore's.
    void copy(ChunkStore& store, StoredChunk& chunk, std::size_t i, std::size_t row) const {
      for (const Target& target : targets_) {
        const std::byte* const value = store.bytes(chunk, *target.column, i) - target.column->byte;
        std::memcpy(target.values + row * target.size, value, target.size);
      }
    }

   private:
    struct Target {
      const StoredColumn* column;  ///< a column of the blob
      std::byte* values;           ///< of the first row
      std::size_t size;            ///< bytes per point
    };
    std::vector<Target> targets_;
  };

  /// The id of a point. Errors: ChunkStore's; an id that is not below the number of points.
  std::uint64_t id(ChunkStore& store, StoredChunk& chunk, std::size_t i) const {
    const auto number = load<std::uint64_t>(store.bytes(chunk, schema_.columns.front(), i));
    if (number >= schema_.point_count) {
      reject(chunk.id, "ids do not match the rows", fmt::format("each id below {} once", schema_.point_count),
             number);
    }
    return number;
  }

  /// Throws the Error about a number in a chunk.
  [[noreturn]] void reject(std::uint64_t chunk, std::string problem, std::string expected,
                           std::uint64_t found) const {
    reject(fmt::format(", chunk {}", chunk), std::move(problem), std::move(expected), std::to_string(found));
  }

 private:
  static constexpr const char* k_schema = "main";

  [[noreturn]] void reject(const std::string& part, std::string problem, std::string expected,
                           std::string found) const {
    throw Error(name_.file, "table " + table_ + part, std::move(problem), std::move(expected),
                std::move(found));
  }

  SqliteCloudName name_;
  Connection connection_;
  std::string table_;
  CloudSchema schema_;
  std::vector<StoredBlob> blobs_;
  std::vector<const StoredColumn*> dimensions_;
  std::uint64_t file_bytes_;
};

std::vector<ChunkLocation> wanted_chunks(ChunkStore& store, std::span<const PointFilter> any_of) {
  std::vector<ChunkLocation> chunks;
  for (const PointFilter& filter : any_of)
    std::ranges::move(store.chunks(filter, std::nullopt), std::back_inserter(chunks));
  std::ranges::sort(chunks, {}, &ChunkLocation::id);
  // Not std::ranges::unique: clang 14 rejects the subranges of GCC's library.
  const auto have_equal_ids = [](const ChunkLocation& a, const ChunkLocation& b) { return a.id == b.id; };
  chunks.erase(std::unique(chunks.begin(), chunks.end(), have_equal_ids), chunks.end());
  return chunks;
}

/// Sorts the rows by their ids.
void sort_by_id(CloudPart& part, const StoredCloud& stored) {
  std::vector<std::uint32_t> order(part.ids.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t row) { return part.ids[row]; });
  reorder_attributes(part.cloud, order);
  std::vector<LatticePosition> positions;
  std::vector<std::uint64_t> ids;
  for (const std::uint32_t row : order) {
    positions.push_back(part.cloud.positions[row]);
    if (!ids.empty() && ids.back() == part.ids[row])
      stored.reject(stored.schema().chunk_count, "duplicate point id", "unique ids", ids.back());
    ids.push_back(part.ids[row]);
  }
  part.cloud.positions = std::move(positions);
  part.ids = std::move(ids);
}

constexpr std::string_view k_first_bytes{"SQLite format 3\0", 16};

class SqliteCloudReader final : public CloudReader {
 public:
  explicit SqliteCloudReader(const InputFile& input) : stored_(input.name()) {
    facts_ = {.bytes = input.size(),
              .work = stored_.file_bytes(),
              .attributes = stored_.attributes(),
              .lattice = schema().lattice,
              .point_count = schema().point_count,
              .crs = schema().crs,
              .gps_time_is_standard = schema().gps_time_is_standard};
    if (schema().point_count > 0) facts_.box = stored_.bounds();
    facts_.file.path = input.name();
    facts_.file.format = "SQLite";
    facts_.file.version = std::to_string(k_cloud_table_version);
    facts_.file.point_count = schema().point_count;
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    const AttributeSet kept = facts_.attributes & wanted;
    const auto bytes = static_cast<double>(stored_.file_bytes());
    const std::uint64_t all = schema().point_count;
    for (std::uint64_t row = 0; row < all;) {
      const std::size_t count = room_in_piece(cloud, kept, all - row, pieces);
      const Rows rows{row, count, cloud.size()};
      append_rows(cloud, kept, count);
      const auto share = [&](std::uint64_t rows_done) {
        return static_cast<double>(rows_done) / static_cast<double>(all);
      };
      take_rows(cloud, kept, rows, [&](double part) {
        report(progress, static_cast<std::uint64_t>(bytes * (share(row) + part * share(count))),
               stored_.file_bytes());
      });
      row += count;
    }
    report(progress, stored_.file_bytes(), stored_.file_bytes());
    return read_rows(all);
  }

 private:
  /// Rows [first, first + count) of the table, for the cloud's rows from `target` on.
  struct Rows {
    std::uint64_t first;
    std::size_t count, target;
  };

  const CloudSchema& schema() const { return stored_.schema(); }

  /// Chunks follow a curve, not the order of rows: each piece is a pass over all of them.
  void take_rows(PointCloud& cloud, AttributeSet kept, const Rows& rows,
                 const std::function<void(double share)>& report_progress) {
    const LatticeShift shift(schema().lattice, cloud.lattice, stored_.file());
    const StoredCloud::Columns columns(stored_, cloud, kept, rows.target);
    ChunkStore store = stored_.chunks();
    std::vector<bool> is_there(rows.count);
    std::uint64_t points = 0;
    std::size_t taken = 0;
    for (const ChunkLocation& location : store.chunks({}, std::nullopt)) {
      const std::uint64_t id = location.id;
      const std::shared_ptr<StoredChunk> chunk = store.read(location);
      for (std::size_t i = 0; i < chunk->positions.size(); ++i) {
        const std::uint64_t row = stored_.id(store, *chunk, i) - rows.first;
        if (row >= rows.count) continue;
        if (is_there[row]) stored_.reject(id, "duplicate point id", "unique ids", rows.first + row);
        is_there[row] = true;
        ++taken;
        cloud.positions[rows.target + row] = shift(chunk->positions[i]);
        columns.copy(store, *chunk, i, row);
      }
      points += chunk->positions.size();
      report_progress(static_cast<double>(id + 1) / static_cast<double>(schema().chunk_count));
    }
    if (points != schema().point_count || taken != rows.count) {
      stored_.reject(schema().chunk_count, "missing points", std::to_string(schema().point_count), points);
    }
  }

  StoredCloud stored_;
};

}  // namespace

CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress) {
  const StoredCloud stored(name);
  ChunkStore store = stored.chunks();
  CloudPart part;
  part.cloud.lattice = stored.schema().lattice;
  part.cloud.crs = stored.schema().crs;
  part.cloud.gps_time_is_standard = stored.schema().gps_time_is_standard;
  part.attributes = stored.attributes();
  part.chunk_count = stored.schema().chunk_count;
  const std::vector<ChunkLocation> chunks = wanted_chunks(store, any_of);
  const AttributeSet kept = part.attributes & attributes;
  for (const ChunkLocation& location : chunks) {
    const std::shared_ptr<StoredChunk> chunk = store.read(location);
    const std::size_t first = part.ids.size(), count = chunk->positions.size();
    // The number of rows is doubled, since columns are copied when they grow.
    if (first + count > part.cloud.size()) append_rows(part.cloud, kept, std::max(first, count));
    const StoredCloud::Columns columns(stored, part.cloud, kept, first);
    for (std::size_t i = 0; i < count; ++i) {
      part.cloud.positions[first + i] = chunk->positions[i];
      part.ids.push_back(stored.id(store, *chunk, i));
      columns.copy(store, *chunk, i, i);
    }
    report(progress, ++part.chunks_read, chunks.size());
  }
  part.cloud.resize(part.ids.size());
  sort_by_id(part, stored);
  CloudFile& file = part.cloud.files.emplace_back();
  file.path = name;
  file.format = "SQLite";
  file.version = std::to_string(k_cloud_table_version);
  file.point_count = part.ids.size();
  return part;
}

const CloudFormat k_sqlite_format{
    .name = "SQLite",
    .is_named = [](std::string_view name) { return name.find(k_table_word) != std::string_view::npos; },
    .is_begun_by =
        [](std::span<const std::byte> start) {
          return std::string_view(reinterpret_cast<const char*>(start.data()), start.size())
              .starts_with(k_first_bytes);
        },
    .open = [](InputFile input, Damage) -> std::unique_ptr<CloudReader> {
      return std::make_unique<SqliteCloudReader>(input);
    }};

}  // namespace alidade::database
