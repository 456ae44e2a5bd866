// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/progress.h"
#include "database/point_stream.h"

namespace alidade::database {

/// A database of a PostgreSQL server for a part of a cloud.
struct Shard {
  std::string host;  ///< name or address
  int port = 5432;
  std::string database;

  bool operator==(const Shard&) const = default;
};

/// Reads "HOST/DATABASE" or "HOST:PORT/DATABASE"; addresses of IPv6 are in brackets: "[::1]:5433/site".
/// Errors: anything else, also a user or a password, which do not belong on a command line.
Shard parse_shard(std::string_view text);

struct ShardPlanOptions {
  std::string table = "points";  ///< name in SQL of the cloud, and of its part on every shard
  Progress progress{};           ///< in points
};

/// Lets write_shard_plan() fail before points are read. Errors: the folder exists; a table's name that is
/// empty, longer than 40 bytes or has control characters.
void check_shard_plan(const std::filesystem::path& folder, const std::string& table);

/// Writes a folder with files that store a cloud on several PostgreSQL servers, which have the extension
/// alidade_pg: for shard i, from 1 on, its part of the points along a Morton curve (shard_i.copy), all parts
/// of equal size up to one point, and the script of its table (shard_i.sql); the script of the table over all
/// shards for a server that queries them through postgres_fdw (coordinator.sql); and README.txt with
/// the commands to type. Every part has its box as a CHECK. The folder is written completely or not at all.
///
/// Errors: those of check_shard_plan(); the folder cannot be written; fewer points than shards; too many
/// columns for PostgreSQL. Cancelled.
void write_shard_plan(const std::filesystem::path& folder, OrderedCloud& cloud, std::span<const Shard> shards,
                      const ShardPlanOptions& options = {});

}  // namespace alidade::database
