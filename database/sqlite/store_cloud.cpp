// SPDX-License-Identifier: MIT
#include "database/sqlite/store_cloud.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <utility>
#include <vector>

#include "database/morton_order.h"
#include "database/sqlite/box_tree.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/connection.h"
#include "database/sqlite/statement.h"
#include "database/value_blobs.h"

namespace alidade {
namespace {

constexpr const char* k_schema = "main";

/// Writes chunk after chunk.
class ChunkWriter {
 public:
  ChunkWriter(sqlite3* database, const std::string& table, const PointCloud& cloud)
      : cloud_(cloud),
        columns_(columns_of(cloud)),
        sources_(value_blobs(columns_)),
        chunk_(database, "INSERT INTO " + part_name(k_schema, table, "chunk") + " VALUES(?,?,?)"),
        value_(database, "INSERT INTO " + part_name(k_schema, table, "value") + " VALUES(?,?)") {}

  void write(std::uint64_t id, std::span<const std::uint32_t> rows) {
    std::vector<LatticePosition> positions;
    std::vector<std::uint64_t> ids(rows.begin(), rows.end());
    Bounds bounds;
    for (const std::uint32_t row : rows) {
      positions.push_back(cloud_.positions[row]);
      bounds.grow(cloud_.world(row));
    }
    chunk_.bind(1, static_cast<std::int64_t>(id)).bind(2, static_cast<std::int64_t>(rows.size()));
    chunk_.bind(3, std::as_bytes(std::span(positions))).run();
    boxes_.push_back(bounds);
    write_values(value_id(0, id), std::as_bytes(std::span(ids)));
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const ValueBlob& source = sources_[i];
      bytes_.resize(rows.size() * source.size);
      for (std::size_t row = 0; row < rows.size(); ++row)
        std::memcpy(bytes_.data() + row * source.size, source.values + rows[row] * source.size, source.size);
      write_values(value_id(static_cast<int>(i) + 1, id), bytes_);
    }
  }

  /// Of the chunks written so far.
  std::vector<Bounds> boxes() && { return std::move(boxes_); }

 private:
  void write_values(std::int64_t id, std::span<const std::byte> bytes) {
    value_.bind(1, id).bind(2, bytes).run();
  }

  const PointCloud& cloud_;
  AttributeColumns columns_;
  std::vector<ValueBlob> sources_;
  Statement chunk_, value_;
  std::vector<Bounds> boxes_;
  std::vector<std::byte> bytes_;
};

bool exists(sqlite3* database, const std::string& table) {
  Statement found(database, "SELECT 1 FROM main.sqlite_schema WHERE lower(name) = lower(?)");
  return found.bind(1, table).step();
}

/// Inside a transaction, which ends when it returns, and is undone if it throws.
void store(sqlite3* database, const PointCloud& cloud, const StoreOptions& options) {
  const CloudSchema schema{.lattice = cloud.lattice,
                           .point_count = cloud.size(),
                           .chunk_count = (cloud.size() + options.chunk_points - 1) / options.chunk_points,
                           .crs_wkt = cloud.crs.wkt,
                           .columns = stored_columns(cloud)};
  if (exists(database, options.table)) {
    if (!options.replace || !exists(database, options.table + "_bounds")) {
      throw Error({.problem = fmt::format("there is a table {} already", options.table),
                   .expected = options.replace ? "a cloud to replace" : "another name"});
    }
    run(database, "DROP TABLE main." + sql_name(options.table));
  }
  create_cloud_tables(database, k_schema, options.table, schema);
  const std::vector<std::uint32_t> order = morton_order(cloud.positions);
  {
    ChunkWriter writer(database, options.table, cloud);
    constexpr std::uint64_t k_chunks_per_report = 64;
    for (std::uint64_t id = 0; id < schema.chunk_count; ++id) {
      const std::size_t first = static_cast<std::size_t>(id * options.chunk_points);
      const std::size_t count = std::min<std::size_t>(options.chunk_points, order.size() - first);
      writer.write(id, std::span(order).subspan(first, count));
      if (id % k_chunks_per_report == 0) report(options.progress, first + count, cloud.size());
    }
    write_box_tree(database, part_name(k_schema, options.table, "bounds"), std::move(writer).boxes());
  }
  run(database, "CREATE VIRTUAL TABLE main." + sql_name(options.table) + " USING pointcloud");
  report(options.progress, cloud.size(), cloud.size());
}

void store_in(const std::filesystem::path& file, Connection::Mode mode, const PointCloud& cloud,
              const StoreOptions& options) {
  const Connection connection(file, mode);
  sqlite3* const database = connection.get();
  if (mode == Connection::Mode::create) {
    // Nobody sees this file before it is whole.
    run(database, "PRAGMA page_size = 16384");
    Statement(database, "PRAGMA journal_mode = OFF").step();
    run(database, "PRAGMA synchronous = OFF");
  }
  run(database, "BEGIN IMMEDIATE");
  try {
    store(database, cloud, options);
    run(database, "COMMIT");
  } catch (...) {
    sqlite3_exec(database, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

void flush_to_disk(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_flushed = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!is_flushed) throw Error({.file = file.string(), .problem = "cannot be written to the disk"});
}

}  // namespace

void store_cloud(const std::filesystem::path& file, const PointCloud& cloud, const StoreOptions& options) {
  constexpr std::uint32_t k_most_chunk_points = 65536;
  if (options.chunk_points < 1 || options.chunk_points > k_most_chunk_points) {
    throw Error({.problem = "bad number of points per chunk",
                 .expected = fmt::format("1 to {}", k_most_chunk_points),
                 .found = std::to_string(options.chunk_points)});
  }
  if (options.table.empty()) throw Error({.problem = "the table has no name"});
  if (cloud.size() > UINT32_MAX) {
    throw Error({.problem = "too many points for one table",
                 .expected = fmt::format("at most {}", UINT32_MAX),
                 .found = std::to_string(cloud.size())});
  }
  if (std::filesystem::exists(file)) {
    store_in(file, Connection::Mode::write, cloud, options);
    return;
  }
  const std::filesystem::path beside = file.string() + fmt::format(".part{}", ::getpid());
  try {
    store_in(beside, Connection::Mode::create, cloud, options);
    flush_to_disk(beside);
    std::filesystem::rename(beside, file);
  } catch (...) {
    std::error_code error;
    std::filesystem::remove(beside, error);
    throw;
  }
}

}  // namespace alidade
