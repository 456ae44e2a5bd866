// SPDX-License-Identifier: MIT
#include "database/server/shard_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "database/morton_order.h"
#include "database/server/copy_rows.h"
#include "database/server/shard_script.h"
#include "octree/cloud/output_file.h"
#include "octree/error.h"

namespace alidade {
namespace {

void write_text(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path, false);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

void check(const PointCloud& cloud, std::span<const Shard> shards, const std::string& table) {
  // PostgreSQL keeps 63 bytes of a name, and parts of the cloud have the table's name with something behind.
  constexpr std::size_t k_longest_table = 40;
  const auto is_control = [](char letter) { return static_cast<unsigned char>(letter) < 0x20; };
  if (table.empty() || table.size() > k_longest_table || std::ranges::any_of(table, is_control)) {
    throw Error({.problem = "this cannot be the name of a table on a server",
                 .expected = fmt::format("1 to {} bytes without control characters", k_longest_table),
                 .found = fmt::format("{} bytes", table.size())});
  }
  if (shards.empty() || cloud.size() < shards.size() || cloud.size() > UINT32_MAX) {
    throw Error(
        {.problem = fmt::format("{} points cannot be spread over {} shards", cloud.size(), shards.size()),
         .expected = fmt::format("a point for each shard, and at most {} points", UINT32_MAX)});
  }
  constexpr std::size_t k_most_columns = 1600;
  const std::size_t columns = stored_columns(cloud).size() + 3;
  if (columns > k_most_columns) {
    throw Error({.problem = "the cloud has too many attributes for a table of PostgreSQL",
                 .expected = fmt::format("at most {} columns", k_most_columns),
                 .found = std::to_string(columns)});
  }
}

/// Writes the rows of a shard, and tells their box.
Bounds write_rows(const std::filesystem::path& path, const PointCloud& cloud, const CopyRows& rows,
                  std::span<const std::uint32_t> order, std::uint64_t done, const Progress& progress) {
  constexpr std::size_t k_rows_at_once = 8192;
  OutputFile file(path, false);
  file.write(CopyRows::head());
  Bounds box;
  std::vector<std::byte> bytes;
  while (!order.empty()) {
    const auto now = order.first(std::min(k_rows_at_once, order.size()));
    bytes.clear();
    for (const std::uint32_t row : now) {
      box.grow(cloud.world(row));
      rows.append(row, bytes);
    }
    file.write(bytes);
    order = order.subspan(now.size());
    done += now.size();
    report(progress, done, cloud.size());
  }
  file.write(CopyRows::tail());
  file.commit();
  return box;
}

void write_files(const std::filesystem::path& folder, const PointCloud& cloud, std::span<const Shard> shards,
                 const ShardPlanOptions& options) {
  const CopyRows rows(cloud);
  const std::vector<std::uint32_t> order = morton_order(cloud.positions);
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    const std::size_t begin = order.size() * i / shards.size();
    const std::size_t end = order.size() * (i + 1) / shards.size();
    const std::string name = shard_name(i);
    boxes.push_back(write_rows(folder / (name + ".copy"), cloud, rows,
                               std::span(order).subspan(begin, end - begin), begin, options.progress));
    write_text(folder / (name + ".sql"), shard_script(options.table, rows.columns(), i, boxes.back()));
  }
  write_text(folder / "coordinator.sql", coordinator_script(options.table, rows.columns(), shards, boxes));
  write_text(folder / "README.txt", plan_readme(options.table, shards, boxes));
}

}  // namespace

void write_shard_plan(const std::filesystem::path& folder, const PointCloud& cloud,
                      std::span<const Shard> shards, const ShardPlanOptions& options) {
  check(cloud, shards, options.table);
  const std::filesystem::path whole = (folder / "").parent_path();
  if (std::filesystem::exists(std::filesystem::symlink_status(whole)))
    throw Error(
        {.file = whole.string(), .problem = "exists already", .expected = "the name of a new folder"});
  const std::filesystem::path beside = whole.string() + fmt::format(".part{}", ::getpid());
  std::error_code error;
  if (!std::filesystem::create_directory(beside, error))
    throw Error({.file = whole.string(), .problem = "this folder cannot be made", .found = error.message()});
  try {
    write_files(beside, cloud, shards, options);
    std::filesystem::rename(beside, whole);
  } catch (...) {
    std::filesystem::remove_all(beside, error);
    throw;
  }
}

}  // namespace alidade
