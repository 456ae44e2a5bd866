// SPDX-License-Identifier: MIT
#include "extensions/postgres/job.h"

#include <fmt/format.h>

#include "jobs/cloud_fields.h"

namespace alidade::jobs {

void add_shard_plan_fields(const Fields& fields, ShardPlanRequest& request) {
  add_cloud_files(fields.required(), "files", "FILE...", k_files_help, request.files,
                  add_view_fields(fields));
  fields.required().file("-o,--output", "FOLDER", "output folder", request.output);
  fields.required().words(
      "--shard", "HOST[:PORT]/DATABASE...",
      "databases, each for an equal part of the points; default port 5432. Users and passwords belong "
      "in the servers' user mappings",
      [&shards = request.shards](const std::vector<std::string>& words) {
        shards.clear();
        for (const std::string& word : words) shards.push_back(database::parse_shard(word));
      });
  add_table(fields, request);
  add_storing(fields, request);
}

ShardPlanPlan plan(const ShardPlanRequest& request) {
  database::check_shard_plan(request.output, request.table);
  return ShardPlanPlan(request,
                       {.clouds = request.files, .partial = request.partial, .writes = {request.output}});
}

database::StoredFiles run(const ShardPlanPlan& plan, Listener& listener) {
  const ShardPlanRequest& request = plan.request();
  const auto write = [&](database::OrderedCloud& cloud, const Progress& progress) {
    database::write_shard_plan(request.output, cloud, request.shards,
                               {.table = request.table, .progress = progress});
  };
  // Without a slash at its end: the folder that the output will be in.
  const std::filesystem::path folder = (request.output / "").parent_path().parent_path();
  const database::StoredFiles stored = store_in_stages(request, "writing", {folder, write}, listener);
  listener.note(fmt::format("planned {} points for {} shards in {}; {} lists the commands",
                            stored.point_count, request.shards.size(), request.output.string(),
                            (request.output / "README.txt").string()));
  return stored;
}

}  // namespace alidade::jobs
