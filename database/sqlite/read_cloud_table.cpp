// SPDX-License-Identifier: MIT
#include "database/sqlite/read_cloud_table.h"

#include <functional>

#include "cloud/fit_lattice.h"
#include "cloud/rows.h"
#include "database/sqlite/stored_cloud.h"

namespace alidade {
namespace {

constexpr std::string_view k_first_bytes{"SQLite format 3\0", 16};

class SqliteCloudReader final : public CloudReader {
 public:
  explicit SqliteCloudReader(const std::string& name) : stored_(name) {
    about_.path = name;
    about_.format = "SQLite";
    about_.version = std::to_string(k_cloud_table_version);
    about_.point_count = schema().point_count;
  }

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override { return stored_.attributes(); }
  FileFacts facts() const override {
    FileFacts facts;
    facts.crs = schema().crs;
    facts.gps_time_is_standard = schema().gps_time_is_standard;
    if (schema().point_count > 0) facts.box = stored_.bounds();
    return facts;
  }
  std::optional<Lattice> lattice() const override { return schema().lattice; }
  std::optional<std::uint64_t> point_count() const override { return schema().point_count; }
  std::uint64_t work() const override { return stored_.file_bytes(); }
  CoordinateSurvey survey(const Progress&) override {
    // The lattice is stored: there is nothing to find out.
    return {};
  }
  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override;

 private:
  /// Rows [first, first + count) of the table, which are rows from `target` on of the cloud.
  struct Rows {
    std::uint64_t first;
    std::size_t count, target;
  };

  const CloudSchema& schema() const { return stored_.schema(); }
  void take_rows(PointCloud& cloud, AttributeSet kept, const Rows& rows,
                 const std::function<void(double share)>& tell);

  StoredCloud stored_;
  CloudFile about_;
};

/// Chunks lie along a curve, not in the order of rows: each piece is a pass over all of them.
void SqliteCloudReader::take_rows(PointCloud& cloud, AttributeSet kept, const Rows& rows,
                                  const std::function<void(double share)>& tell) {
  const LatticeShift shift(schema().lattice, cloud.lattice, stored_.file());
  const StoredCloud::Columns columns(stored_, cloud, kept, rows.target);
  ChunkStore store = stored_.chunks();
  std::vector<bool> is_there(rows.count);
  std::uint64_t points = 0;
  std::size_t taken = 0;
  for (const ChunkPlace& place : store.chunks({})) {
    const std::uint64_t id = place.id;
    const std::shared_ptr<StoredChunk> chunk = store.read(place);
    for (std::size_t i = 0; i < chunk->positions.size(); ++i) {
      const std::uint64_t row = stored_.id(store, *chunk, i) - rows.first;
      if (row >= rows.count) continue;
      if (is_there[row])
        stored_.refuse(id, "two points have one id", "each once", std::to_string(rows.first + row));
      is_there[row] = true;
      ++taken;
      cloud.positions[rows.target + row] = shift(chunk->positions[i]);
      columns.copy(store, *chunk, i, row);
    }
    points += chunk->positions.size();
    tell(static_cast<double>(id + 1) / static_cast<double>(schema().chunk_count));
  }
  if (points != schema().point_count || taken != rows.count) {
    stored_.refuse(schema().chunk_count, "points are missing", std::to_string(schema().point_count),
                   std::to_string(points));
  }
}

void SqliteCloudReader::read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                                       const Progress& progress) {
  const AttributeSet kept = attributes() & wanted;
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
}

}  // namespace

CloudDatabase sqlite_clouds() {
  return {.is_named = [](const std::string& name) { return name.find(k_table_word) != std::string::npos; },
          .is_begun_by = [](const std::string& bytes) { return bytes.starts_with(k_first_bytes); },
          .open = [](const std::string& name) -> std::unique_ptr<CloudReader> {
            return std::make_unique<SqliteCloudReader>(name);
          }};
}

}  // namespace alidade
