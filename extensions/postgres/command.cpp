// SPDX-License-Identifier: MIT
#include "tools/command.h"
#include "extensions/postgres/job.h"

namespace alidade::extensions {

void add_postgres(tools::ProgramHooks& hooks) {
  hooks.commands.push_back(
      {"sql", [](const tools::Options& sql) {
         return tools::job_command(
             sql.command("shard-plan", "Plan the distribution of a cloud over several PostgreSQL servers"),
             jobs::add_shard_plan_fields);
       }});
}

}  // namespace alidade::extensions
