// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "base/output_file.h"
#include "base/words.h"
#include "cloud/catalog.h"
#include "cloud/read_cloud.h"
#include "database/server/server_clouds.h"
#include "database/server/server_name.h"
#include "database/server/shard_plan.h"
#include "database/sqlite/store_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

/// Options of all commands that store clouds in databases; memory need not hold the clouds.
struct LoadOptions : RunRequest {
  ColorDepth color_depth = ColorDepth::automatic;
  std::uint64_t memory = std::uint64_t{1} << 30;
};

/// Declares these options.
void add_load_options(const Fields& command, LoadOptions& options) {
  command.value("--memory", "SIZE",
                "memory for sorting points: bytes, or a number with k, M, G or T (default: 1G); points of a "
                "larger cloud use a temporary file next to the output",
                options.memory, parse_memory);
  command.choice("--color-depth",
                 "bits in use of LAS colours (default: 8 if none exceeds 255); the database stores 16",
                 options.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_run_options(command, options);
}

struct LoadCommand : LoadOptions {
  std::vector<std::filesystem::path> files;  ///< the last one is the database
  CloudView view;
  database::StoreOptions store;
};

/// Errors: the database has the name of a cloud: it was probably forgotten.
void check_name(const std::filesystem::path& database) {
  constexpr const char* k_clouds[] = {".las", ".laz", ".ply", ".pcd",     ".e57",    ".pts",
                                      ".ptx", ".xyz", ".csv", ".alidade", ".parquet"};
  const std::string extension = file_extension(database);
  if (!is_catalog_name(database.string()) && std::ranges::find(k_clouds, extension) == std::end(k_clouds))
    return;
  throw file_error(database, "the database name is that of a cloud file",
                   "the database as the last name, such as site.db");
}

/// The table on the server. Errors: it is named twice; options for SQLite only.
database::ServerName server_name(const LoadCommand& command) {
  database::ServerName name(command.files.back().string());
  const database::StoreOptions other;
  const bool is_named_twice = !name.table.empty() && command.store.table != other.table;
  if (is_named_twice || command.store.chunk_points != other.chunk_points) {
    throw file_error(name.shown(),
                     is_named_twice ? "duplicate table name" : "--chunk-points does not apply to servers",
                     is_named_twice ? "?table= or --table" : "no --chunk-points");
  }
  if (name.table.empty()) name.table = command.store.table;
  return name;
}

ExitCode run(const LoadCommand& command) {
  const std::filesystem::path& database = command.files.back();
  const CloudInputs files = command.view.apply(
      resolve_clouds(std::span(command.files).first(command.files.size() - 1), cloud_formats()));
  std::optional<database::ServerName> server;
  if (database::is_server_name(database.string())) {
    server = server_name(command);
  } else {
    check_name(database);
    // An existing database stays: --overwrite replaces a table in it.
    if (!command.store.replace) check_links(database);
    check_writable(database, true, files.names());
  }
  const auto work = [&](const ReadOptions& reading, const Progress& storing) {
    if (server)
      return database::store_on_server(*server, files, reading,
                                       {command.store.replace, command.memory, storing});
    database::StoreOptions options = command.store;
    options.memory = command.memory;
    options.progress = storing;
    return database::store_files(database, files, reading, options);
  };
  const std::uint64_t count = store_shown(command, command.color_depth, "storing", work).point_count;
  const std::string location =
      server ? server->shown() : fmt::format("table {} of {}", command.store.table, database.string());
  say_note(command.verbosity, fmt::format("stored {} points as {}", count, location));
  return ExitCode::done;
}

struct ShardPlanCommand : LoadOptions {
  CloudInputs files;
  std::filesystem::path output;
  std::vector<database::Shard> shards;
  std::string table = "points";
};

ExitCode run(const ShardPlanCommand& command) {
  const auto work = [&](const ReadOptions& reading, const Progress& writing) {
    return database::write_shard_plan(
        command.output, command.files, reading, command.shards,
        {.table = command.table, .memory = command.memory, .progress = writing});
  };
  const std::uint64_t count = store_shown(command, command.color_depth, "writing", work).point_count;
  say_note(command.verbosity, fmt::format("planned {} points for {} shards in {}; {} lists the commands",
                                          count, command.shards.size(), command.output.string(),
                                          (command.output / "README.txt").string()));
  return ExitCode::done;
}

}  // namespace

Command add_sql_load(const Options& sql) {
  auto command = std::make_shared<LoadCommand>();
  const Options load = sql.command("load", "Store a cloud in a database");
  load.required().words(
      "files", "FILE... DB",
      "cloud files, folders, catalogs or patterns such as 'tiles/*.las', joined into one cloud; then the "
      "database, an SQLite file, created if missing, or 'postgresql://HOST/DATABASE?table=NAME'",
      [command](const std::vector<std::string>& words) { command->files.assign(words.begin(), words.end()); },
      2);
  command->view = add_view_fields(load);
  load.text("--table", "NAME", "table name of the cloud (default: points)", command->store.table);
  load.count("--chunk-points", "N", "points per chunk of SQLite, 1 to 65536 (default: 1024)",
             command->store.chunk_points, 1, 65536);
  load.flag("--overwrite", "replace an existing cloud of that name", command->store.replace);
  add_load_options(load, *command);
  return command_of(load, command, run);
}

Command add_sql_shard_plan(const Options& sql) {
  auto command = std::make_shared<ShardPlanCommand>();
  const Options plan =
      sql.command("shard-plan", "Plan the distribution of a cloud over several PostgreSQL servers");
  add_cloud_files(plan.required(), "files", "FILE...", k_files_help, command->files, add_view_fields(plan));
  plan.required().file("-o,--output", "FOLDER", "output folder", command->output);
  plan.required().words(
      "--shard", "HOST[:PORT]/DATABASE...",
      "databases, each for an equal part of the points; default port 5432. Users and passwords belong "
      "in the servers' user mappings",
      [command](const std::vector<std::string>& words) {
        command->shards.clear();
        for (const std::string& word : words) command->shards.push_back(database::parse_shard(word));
      });
  plan.text("--table", "NAME", "table name of the cloud (default: points)", command->table);
  add_load_options(plan, *command);
  return command_of(plan, command, run);
}

}  // namespace alidade::tools
