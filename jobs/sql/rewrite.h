// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "database/sql/rewrite_statement.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/sql/statement.h"

namespace alidade::jobs {

/// Statements for engines without dist_ray.
struct RewriteRequest {
  SqlSource source;
  database::RewriteOptions options;
};

/// Declares all fields. Bounds are numbers, or a cloud that states them. Errors of that field: those of
/// resolve_clouds(); a cloud that does not state them.
void add_rewrite_fields(const Fields& fields, RewriteRequest& request);

using RewritePlan = Plan<RewriteRequest>;

RewritePlan plan(const RewriteRequest& request);

/// Rewrites each statement of the source, and notes how its conditions prune. Errors: those of read_sql() and
/// database::rewrite_statement().
std::vector<database::RewrittenStatement> run(const RewritePlan& plan, Listener& listener);

}  // namespace alidade::jobs
