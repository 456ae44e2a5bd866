// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "database/server/shard.h"
#include "octree/cloud/point_cloud.h"
#include "octree/progress.h"

namespace alidade {

struct ShardPlanOptions {
  std::string table = "points";  ///< what SQL calls the cloud, and its part on every shard
  Progress progress{};           ///< in points
};

/// Writes a folder with all that puts a cloud on several PostgreSQL servers, which have the extension
/// alidade_pg: for shard i, from 1 on, its part of the points along a Morton curve (shard_i.copy), all parts
/// equally large but for one point, and what makes its table (shard_i.sql); what makes the table over all of
/// them for a server that asks the shards through postgres_fdw (coordinator.sql); and README.txt, which tells
/// what to type. Every part states its box as a CHECK. The folder is there as a whole or not at all.
///
/// Errors: the folder exists or cannot be written; fewer points than shards; 2^32 points or more; too many
/// columns for PostgreSQL; a table's name that is empty, longer than 40 bytes or has control characters.
/// Cancelled. Memory: 36 bytes per point beside the cloud.
void write_shard_plan(const std::filesystem::path& folder, const PointCloud& cloud,
                      std::span<const Shard> shards, const ShardPlanOptions& options = {});

}  // namespace alidade
