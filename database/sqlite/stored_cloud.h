// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "cloud/point_cloud.h"
#include "database/point_filter.h"
#include "database/sqlite/chunk_store.h"
#include "database/sqlite/connection.h"

namespace alidade::database {

inline constexpr std::string_view k_table_word = "?table=";

/// "site.db", a file, or "site.db?table=NAME", a table of its; without a name it must be the only cloud in
/// the file.
struct SqliteCloudName {
  std::string file, table;

  explicit SqliteCloudName(const std::string& name);
};

/// The columns of one blob, by their offsets.
struct StoredBlob {
  std::vector<const StoredColumn*> columns;
  std::optional<Attribute> attribute{};  ///< none: an extra dimension, or something else
};

/// A cloud in a file, open for reading.
class StoredCloud {
 public:
  /// Errors: the file is no database; it has no cloud, several, or none of the name; what read_cloud_schema()
  /// says; more points than the file has room for.
  explicit StoredCloud(const std::string& name);

  const std::string& file() const { return name_.file; }
  const std::string& table() const { return table_; }
  const CloudSchema& schema() const { return schema_; }
  std::uint64_t file_bytes() const { return file_bytes_; }
  /// Of PointCloud.
  AttributeSet attributes() const;
  /// Of all points, as the boxes of the chunks say; empty if there are none.
  Bounds bounds() const;
  ChunkStore chunks() const { return {connection_.get(), k_schema, table_, schema_}; }

  /// Copies attributes of stored points into rows of a cloud.
  class Columns {
   public:
    /// The attributes `kept`, of those that attributes() has; all columns of the cloud are there. `first_row`
    /// is the cloud's row for row 0.
    Columns(const StoredCloud& stored, PointCloud& cloud, AttributeSet kept, std::size_t first_row);

    /// Errors: ChunkStore's.
    void copy(ChunkStore& store, StoredChunk& chunk, std::size_t i, std::size_t row) const;

   private:
    struct Target {
      const StoredColumn* column;  ///< a column of the blob
      std::byte* values;           ///< of the first row
      std::size_t size;            ///< bytes per point
    };
    std::vector<Target> targets_;
  };

  /// The number of a point. Errors: ChunkStore's; there is no such number.
  std::uint64_t id(ChunkStore& store, StoredChunk& chunk, std::size_t i) const;

  [[noreturn]] void reject(std::uint64_t chunk, std::string problem, std::string expected,
                           std::string found) const;

 private:
  static constexpr const char* k_schema = "main";

  SqliteCloudName name_;
  Connection connection_;
  std::string table_;
  CloudSchema schema_;
  std::vector<StoredBlob> blobs_;
  std::vector<const StoredColumn*> dimensions_;
  std::uint64_t file_bytes_;
};

/// Reads the points of those chunks of a cloud in SQLite that may hold one for which a filter holds, and so
/// at least all for which one does. `progress` is in chunks. Errors: StoredCloud's and ChunkStore's; two
/// points with one id. Cost: each filter is tested against boxes of chunks, level by level; the chunks.
CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress = {});

/// Clouds that store_cloud() wrote: points come back in the rows they had, with all
/// attributes. Names: SqliteCloudName. Errors when opened: StoredCloud's. When read: ChunkStore's; ids that
/// are no rows.
extern const CloudFormat k_sqlite_format;

}  // namespace alidade::database
