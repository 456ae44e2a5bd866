// SPDX-License-Identifier: MIT
#include "database/server/shard_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <functional>

#include "base/error.h"
#include "base/output_file.h"
#include "database/server/copy_format.h"
#include "database/server/shard_script.h"
#include "database/streamed_columns.h"

namespace alidade {
namespace {

void write_text(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path, false);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

/// A cloud along the Morton curve.
struct OrderedCloud {
  explicit OrderedCloud(const std::filesystem::path& folder) : points(folder) {}

  PointStream points;
  PiecewiseCloud whole{};
};

/// Writes the next `count` rows, those of a shard, and tells their box.
Bounds write_rows(const std::filesystem::path& path, OrderedCloud& cloud, const CopyRows& rows,
                  std::uint64_t count, const std::function<void(std::size_t)>& tell) {
  OutputFile file(path, false);
  const Bounds box =
      rows.copy(cloud.points, cloud.whole, count, [&](std::span<const std::byte> bytes, std::size_t points) {
        file.write(bytes);
        tell(points);
      });
  file.commit();
  return box;
}

void write_files(const std::filesystem::path& folder, OrderedCloud& cloud, std::span<const Shard> shards,
                 const ShardPlanOptions& options) {
  const CopyRows rows(streamed_columns(cloud.whole, cloud.points), cloud.whole.rest.lattice);
  check_column_count(rows.columns());
  const std::uint64_t size = cloud.points.size();
  if (shards.empty() || size < shards.size()) {
    throw Error({.problem = fmt::format("{} points cannot be spread over {} shards", size, shards.size()),
                 .expected = "a point or more for each shard"});
  }
  std::uint64_t done = 0;
  const auto tell = [&](std::size_t count) {
    done += count;
    report(options.progress, done, size);
  };
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    const std::string name = shard_name(i);
    const std::uint64_t count = size / shards.size() + (i < size % shards.size() ? 1 : 0);
    boxes.push_back(write_rows(folder / (name + ".copy"), cloud, rows, count, tell));
    write_text(folder / (name + ".sql"), shard_script(options.table, rows.columns(), i, boxes.back()));
  }
  Bounds whole_box;
  for (const Bounds& box : boxes) whole_box.grow(box);
  write_text(folder / "coordinator.sql", coordinator_script(options.table, rows.columns(), shards, boxes,
                                                            cloud_row(cloud.whole, whole_box)));
  write_text(folder / "README.txt", plan_readme(options.table, shards, boxes));
}

}  // namespace

ShardPlan write_shard_plan(const std::filesystem::path& folder, std::span<const std::filesystem::path> files,
                           const ReadOptions& reading, std::span<const Shard> shards,
                           const ShardPlanOptions& options) {
  check_server_table(options.table);
  const std::filesystem::path whole_folder = (folder / "").parent_path();
  if (std::filesystem::exists(std::filesystem::symlink_status(whole_folder))) {
    throw Error(
        {.file = whole_folder.string(), .problem = "exists already", .expected = "the name of a new folder"});
  }
  const std::filesystem::path beside = whole_folder.string() + fmt::format(".part{}", ::getpid());
  std::error_code error;
  if (!std::filesystem::create_directory(beside, error)) {
    throw Error(
        {.file = whole_folder.string(), .problem = "this folder cannot be made", .found = error.message()});
  }
  try {
    OrderedCloud cloud(beside);
    cloud.whole = read_in_pieces(files, reading,
                                 {.most_bytes = options.memory,
                                  .bytes_beside = PointStream::k_bytes_beside,
                                  .take = [&](PointCloud& piece) { cloud.points.add(piece); }});
    cloud.points.finish(cloud.whole.rest);
    write_files(beside, cloud, shards, options);
    std::filesystem::rename(beside, whole_folder);
    return {cloud.points.size(), std::move(cloud.whole.rest.warnings)};
  } catch (...) {
    std::filesystem::remove_all(beside, error);
    throw;
  }
}

}  // namespace alidade
