// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cloud/read_cloud.h"
#include "database/point_stream.h"
#include "database/server/server_name.h"
#include "database/server/shard_plan.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A cloud that is stored in databases. `memory` sorts points, by default 1 GB; it need not hold the cloud.
struct StoreRequest : CloudRequest {
  std::string table = "points";  ///< name of the cloud in SQL
  ColorDepth color_depth = ColorDepth::automatic;
};

/// A cloud for a database, the `output`: an SQLite file, or a table of a server (database::ServerName).
/// `overwrite`: an existing cloud of that name.
struct LoadRequest : StoreRequest {
  std::optional<std::uint32_t> chunk_points;  ///< of SQLite, 1 to 65536; empty: 1024
};

/// A cloud for several servers; `output` is a folder.
struct ShardPlanRequest : StoreRequest {
  std::vector<database::Shard> shards;
};

/// Declare all fields.
void add_load_fields(const Fields& fields, LoadRequest& request);
void add_shard_plan_fields(const Fields& fields, ShardPlanRequest& request);

struct CheckedLoad : LoadRequest {
  std::optional<database::ServerName> server;  ///< empty: an SQLite file
};
using LoadPlan = Plan<CheckedLoad>;
using ShardPlanPlan = Plan<ShardPlanRequest>;

/// Checks all that can be checked before a point is read. Errors: a database with the name of a cloud, or
/// that is one of the files or cannot be written; a table on a server that is named twice, or has chunks;
/// those of database::check_shard_plan().
LoadPlan plan(const LoadRequest& request);
ShardPlanPlan plan(const ShardPlanRequest& request);

/// Stores the cloud as a table, and notes where. Errors: those of database::store_files() and
/// database::store_on_server(); Cancelled. Memory: theirs.
database::StoredFiles run(const LoadPlan& plan, Listener& listener);

/// Writes the folder. Errors: those of database::write_shard_plan(); Cancelled. Memory: its.
database::StoredFiles run(const ShardPlanPlan& plan, Listener& listener);

}  // namespace alidade::jobs
