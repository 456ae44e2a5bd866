// SPDX-License-Identifier: MIT
#include "database/sqlite/store_cloud.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <span>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/output_file.h"
#include "base/parallel.h"
#include "base/words.h"
#include "database/sqlite/chunk_store.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/connection.h"

namespace alidade::database {

namespace {

constexpr const char* k_schema = "main";

/// Writes chunks into the tables of a cloud (database/sqlite/cloud_schema.h).
class ChunkWriter {
 public:
  ChunkWriter(sqlite3* database, const std::string& table, const ChunkEncoding& encoding)
      : encoding_(encoding),
        chunk_(database, "INSERT INTO " + part_name(k_schema, table, "chunk") + " VALUES(?,?,?)"),
        value_(database, "INSERT INTO " + part_name(k_schema, table, "value") + " VALUES(?,?)") {}

  void write(const EncodedChunks& chunks) {
    const std::size_t count = chunks.positions.size();
    const std::uint64_t first = boxes_.size();
    const auto points_of = [&](std::size_t chunk) {
      return std::min<std::size_t>(encoding_.chunk_points, count - chunk * encoding_.chunk_points);
    };
    for (std::size_t chunk = 0; chunk < chunks.boxes.size(); ++chunk) {
      const auto positions =
          std::span(chunks.positions).subspan(chunk * encoding_.chunk_points, points_of(chunk));
      chunk_.run_with(static_cast<std::int64_t>(first + chunk), static_cast<std::int64_t>(positions.size()),
                      std::as_bytes(positions));
    }
    // Blob by blob, since rows with the same blob number are neighbours in the table.
    for (std::size_t blob = 0; blob < chunks.blobs.size(); ++blob) {
      const std::size_t size = count == 0 ? 0 : chunks.blobs[blob].size() / count;
      for (std::size_t chunk = 0; chunk < chunks.boxes.size(); ++chunk) {
        value_.run_with(value_id(static_cast<int>(blob), first + chunk),
                        std::span<const std::byte>(chunks.blobs[blob])
                            .subspan(chunk * encoding_.chunk_points * size, points_of(chunk) * size));
      }
    }
    boxes_.insert(boxes_.end(), chunks.boxes.begin(), chunks.boxes.end());
  }

  /// Boxes of the chunks written so far.
  std::vector<Bounds> boxes() && { return std::move(boxes_); }

 private:
  const ChunkEncoding& encoding_;
  Statement chunk_, value_;
  std::vector<Bounds> boxes_;
};

/// Whether there is a cloud to replace. Errors: a table of that name exists and must not be replaced.
bool check_table(sqlite3* database, const StoreOptions& options) {
  // A table of the module is recognised by its SQL, since its ordinary tables may be damaged.
  Statement found(database,
                  "SELECT type = 'table' AND sql LIKE 'CREATE VIRTUAL TABLE % USING pointcloud%'"
                  " FROM main.sqlite_schema WHERE lower(name) = lower(?) ORDER BY 1 DESC");
  if (!found.bind(1, options.table).step()) return false;
  if (options.replace && found.whole(0) != 0) return true;
  throw file_error(file_of(database), fmt::format("the table {} exists", options.table),
                   options.replace ? "a cloud" : "another name, or --overwrite");
}

/// Drops a cloud, also one that cannot be read. SQLite drops only virtual tables that it can open, so the
/// ordinary tables are replaced first.
void drop_cloud(sqlite3* database, const std::string& table) {
  drop_cloud_tables(database, k_schema, table);
  CloudSchema empty;
  empty.columns = stored_columns(PointCloud());
  create_cloud_tables(database, k_schema, table, empty);
  run(database, "DROP TABLE main." + sql_name(table));
}

void write_chunks(PointStream& points, const ChunkEncoding& encoding, ChunkWriter& writer,
                  const Progress& progress) {
  // Points that are processed together.
  constexpr std::uint32_t k_about = 1 << 15;
  const std::size_t group =
      std::size_t{std::max(1u, k_about / encoding.chunk_points)} * encoding.chunk_points;
  // More groups are not faster, and each takes some megabytes.
  constexpr std::size_t k_most_groups = 16;
  std::vector<EncodedChunks> chunks(std::min(2 * thread_count() + 1, k_most_groups));
  std::uint64_t done = 0;
  points.for_each_group(
      group, chunks.size(),
      [&](std::size_t slot, const PickedPoints& picked) { chunks[slot] = encode(encoding, picked); },
      [&](std::size_t slot) {
        writer.write(chunks[slot]);
        done += chunks[slot].positions.size();
        report(progress, done, points.size());
      });
}

/// Stores a cloud in a transaction, which is committed on return and rolled back by an exception.
void store(sqlite3* database, OrderedCloud& cloud, const StoreOptions& options) {
  PointStream& points = cloud.points;
  const PointCloud& whole = cloud.whole.rest;
  if (check_table(database, options)) drop_cloud(database, options.table);
  create_cloud_tables(database, k_schema, options.table,
                      {.lattice = whole.lattice,
                       .point_count = points.size(),
                       .chunk_count = (points.size() + options.chunk_points - 1) / options.chunk_points,
                       .crs = whole.crs,
                       .gps_time_is_standard = whole.gps_time_is_standard,
                       .columns = cloud.columns()});
  const ChunkEncoding encoding = cloud.encoding(options.chunk_points);
  {
    ChunkWriter writer(database, options.table, encoding);
    write_chunks(points, encoding, writer, options.progress);
    write_box_tree(database, part_name(k_schema, options.table, "bounds"), std::move(writer).boxes());
  }
  run(database, "CREATE VIRTUAL TABLE main." + sql_name(options.table) + " USING pointcloud");
  report(options.progress, points.size(), points.size());
}

void store_in(const std::filesystem::path& file, Connection::Mode mode, OrderedCloud& cloud,
              const StoreOptions& options) {
  const Connection connection(file, mode);
  sqlite3* const database = connection.get();
  if (mode == Connection::Mode::create) {
    // Blobs of a chunk take a power of two of bytes and a few more: small pages would have much unused space.
    run(database, "PRAGMA page_size = 65536");
    // The file has no other users until it is complete.
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

/// Flushes a file or folder.
void flush_to_disk(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_flushed = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!is_flushed) throw file_error(path, "cannot write to the disk");
}

/// Gives a complete file its name. Error: a file of that name exists by now.
void give_name(const std::filesystem::path& beside, const std::filesystem::path& file) {
  flush_to_disk(beside);
  if (::renameat2(AT_FDCWD, beside.c_str(), AT_FDCWD, file.c_str(), RENAME_NOREPLACE) != 0) {
    // File systems without the atomic form: a check and a plain rename.
    const bool is_known = errno != EINVAL && errno != ENOSYS;
    if (is_known || std::filesystem::exists(file)) throw system_error(file.string(), "cannot write the file");
    std::filesystem::rename(beside, file);
  }
  flush_to_disk(file.has_parent_path() ? file.parent_path() : ".");
}

void check_name(const std::string& table) {
  check_that(!table.empty() && table.find('\0') == table.npos && !lower_case(table).starts_with("sqlite_"),
             "invalid table name", "a nonempty name that does not begin with sqlite_", "'" + table + "'");
}

}  // namespace

void check_store(const std::filesystem::path& file, const StoreOptions& options) {
  check_that(options.chunk_points >= 1 && options.chunk_points <= k_most_chunk_points,
             "invalid number of points per chunk", fmt::format("1 to {}", k_most_chunk_points),
             std::to_string(options.chunk_points));
  check_name(options.table);
  if (std::filesystem::exists(file)) check_table(Connection(file, Connection::Mode::write).get(), options);
}

void store_cloud(const std::filesystem::path& file, OrderedCloud& cloud, const StoreOptions& options) {
  check_store(file, options);
  const std::uint64_t most_points = std::uint64_t{UINT32_MAX} * options.chunk_points;
  check_that(cloud.points.size() <= most_points, "too many points for one table",
             fmt::format("at most {}", most_points), std::to_string(cloud.points.size()));
  if (std::filesystem::exists(file)) {
    store_in(file, Connection::Mode::write, cloud, options);
    return;
  }
  std::filesystem::path beside;
  const FileDescriptor lock(create_temporary(file, file.string(), beside));
  try {
    store_in(beside, Connection::Mode::create, cloud, options);
    give_name(beside, file);
  } catch (...) {
    std::error_code error;
    std::filesystem::remove(beside, error);
    throw;
  }
}

void store_cloud(const std::filesystem::path& file, const PointCloud& cloud, const StoreOptions& options) {
  OrderedCloud ordered(cloud);
  store_cloud(file, ordered, options);
}

}  // namespace alidade::database
