// SPDX-License-Identifier: MIT
#include "tools/sql_shard_plan.h"

#include <fmt/format.h>

#include <memory>

#include "database/server/shard_plan.h"
#include "tools/cloud_options.h"
#include "tools/message.h"
#include "tools/sql/load_options.h"

namespace alidade {
namespace {

struct ShardPlanCommand {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::vector<Shard> shards;
  std::string table = "points";
  LoadOptions load;
};

ExitCode run(const ShardPlanCommand& command) {
  std::uint64_t count = 0;
  load_with_progress(command.load, "writing", [&](const ReadOptions& reading, const Progress& writing) {
    ShardPlan plan =
        write_shard_plan(command.output, command.files, reading, command.shards,
                         {.table = command.table, .memory = command.load.memory, .progress = writing});
    count = plan.point_count;
    return std::move(plan.warnings);
  });
  if (!command.load.verbosity.quiet) {
    say_note(fmt::format("{} points for {} shards in {}; {} tells what to type", count, command.shards.size(),
                         command.output.string(), (command.output / "README.txt").string()));
  }
  return ExitCode::done;
}

}  // namespace

Command add_sql_shard_plan(CLI::App& sql) {
  auto command = std::make_shared<ShardPlanCommand>();
  CLI::App* const plan =
      sql.add_subcommand("shard-plan", "Write what puts a cloud on several PostgreSQL servers");
  add_cloud_files(*plan, "files", command->files,
                  "cloud files, folders or patterns as 'tiles/*.las', taken together as one")
      ->option_text("FILE...")
      ->required();
  plan->add_option("-o,--output", command->output, "folder to make")->option_text("FOLDER")->required();
  plan->add_option_function<std::vector<std::string>>(
          "--shard",
          [command](const std::vector<std::string>& words) {
            command->shards.clear();
            for (const std::string& word : words) command->shards.push_back(parse_shard(word));
          },
          "databases that take a part of the points each, equally many; port 5432 if none is given. Users "
          "and passwords belong to the servers' user mappings, not here")
      ->option_text("HOST[:PORT]/DATABASE...")
      ->required();
  plan->add_option("--table", command->table, "what SQL calls the cloud (default: points)")
      ->option_text("NAME");
  add_load_options(*plan, command->load);
  plan->footer(
      "Form:\n"
      "  alidade sql shard-plan FILE... --shard HOST[:PORT]/DATABASE... -o FOLDER [OPTIONS]\n"
      "\n"
      "No server is asked. The folder gets, for every shard, its part of the points along a Morton curve and "
      "the script\n"
      "that makes its table from it; the script of the table over all of them (postgres_fdw: the shards look "
      "for their\n"
      "points at the same time); and README.txt with the commands that run them. All servers need the "
      "extension alidade_pg.\n"
      "\n"
      "Example:\n"
      "  alidade sql shard-plan tiles/ --shard db1/site db2/site db3:5433/site -o plan\n");
  return {plan, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->load.threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade
