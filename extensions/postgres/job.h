// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "extensions/postgres/shard_plan.h"
#include "jobs/sql/load.h"

namespace alidade::jobs {

/// A cloud for several servers; `output` is a folder.
struct ShardPlanRequest : StoreRequest {
  std::vector<database::Shard> shards;
};

/// Declares all fields.
void add_shard_plan_fields(const Fields& fields, ShardPlanRequest& request);

using ShardPlanPlan = Plan<ShardPlanRequest>;

/// Checks all that can be checked before a point is read. Errors: those of database::check_shard_plan().
ShardPlanPlan plan(const ShardPlanRequest& request);

/// Writes the folder. Errors: those of database::write_shard_plan(); Cancelled. Memory: its.
database::StoredFiles run(const ShardPlanPlan& plan, Listener& listener);

}  // namespace alidade::jobs
