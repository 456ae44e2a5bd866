// SPDX-License-Identifier: MIT

#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

#include "base/words.h"
#include "cloud/read_cloud.h"
#include "database/server/server_name.h"
#include "database/server/shard_plan.h"
#include "database/server/store_on_server.h"
#include "database/sqlite/store_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/console.h"
#include "tools/options.h"

namespace alidade::tools {

namespace {

/// What commands have in common that put clouds into databases, which memory need not hold.
struct LoadOptions {
  bool partial = false;
  std::optional<ColorDepth> color_depth;
  std::uint64_t memory = std::uint64_t{1} << 30;
  std::optional<int> threads;
  Verbosity verbosity = Verbosity::normal;
};

/// Declares them.
void add_load_options(const Options& command, LoadOptions& options) {
  command.value(
      "--memory", "SIZE",
      "for points while they are sorted: bytes, or a number with k, M, G or T (default: 1G); those of a "
      "larger cloud wait in a file without a name beside the output",
      [&options](const std::string& text) {
        constexpr std::size_t k_least = std::size_t{1} << 20;
        options.memory = parse_size(text);
        if (options.memory < k_least) throw UsageError("expected at least 1M, found '" + text + "'");
      });
  command.choice("--color-depth",
                 "bits in use of LAS colours (default: 8 if none exceeds 255); 16 are stored",
                 options.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(command, options.partial);
  add_threads(command, options.threads);
  add_verbosity(command, options.verbosity);
}

/// Does `work`, which reads files and then stores points, with a progress line for each; prints the warnings
/// that it answers. `storing` is what the second line says.
void load_with_progress(const LoadOptions& options, const std::string& storing,
                        const std::function<std::vector<std::string>(const ReadOptions& reading,
                                                                     const Progress& storing)>& work) {
  const Verbosity verbosity = options.verbosity;
  ProgressLine read_line("reading", "B", verbosity);
  std::optional<ProgressLine> store_line;
  Progress store_progress;
  const ReadOptions reading{.color_depth = options.color_depth.value_or(ColorDepth::automatic),
                            .partial = options.partial,
                            .progress = read_line.callback()};
  const std::vector<std::string> warnings = work(reading, [&](std::uint64_t done, std::uint64_t total) {
    if (!store_line) {
      read_line.finish();
      store_line.emplace(storing, "points", verbosity);
      store_progress = store_line->callback();
    }
    return store_progress(done, total);
  });
  if (store_line) store_line->finish();
  if (verbosity == Verbosity::quiet) return;
  for (const std::string& warning : warnings) say_warning(warning);
}

struct LoadCommand {
  std::vector<std::filesystem::path> files;  ///< the last one is the database
  database::StoreOptions store;
  LoadOptions load;
};

/// Who forgot the database has named a cloud there.
void check_name(const std::filesystem::path& database) {
  constexpr const char* k_clouds[] = {".las", ".laz", ".ply", ".pcd", ".e57",
                                      ".pts", ".ptx", ".xyz", ".csv", ".alidade"};
  const std::string ending = file_ending(database);
  if (std::ranges::find(k_clouds, ending) == std::end(k_clouds)) return;
  throw Error({.file = database.string(),
               .problem = "is the name of a cloud file",
               .expected = "the database as the last name, as site.db"});
}

/// The table that is meant. Errors: it is named twice; options that only SQLite knows.
database::ServerName server_name(const LoadCommand& command) {
  database::ServerName name(command.files.back().string());
  const database::StoreOptions other;
  const bool is_named_twice = !name.table.empty() && command.store.table != other.table;
  if (is_named_twice || command.store.chunk_points != other.chunk_points) {
    throw Error({.file = name.shown(),
                 .problem = is_named_twice ? "the table is named twice" : "a server makes no chunks",
                 .expected = is_named_twice ? "?table= or --table" : "no --chunk-points"});
  }
  if (name.table.empty()) name.table = command.store.table;
  return name;
}

/// Stores files, and answers where.
using Store = std::function<database::StoredFiles(const CloudInputs& files, const ReadOptions& reading,
                                                  const Progress& storing)>;

ExitCode run(const LoadCommand& command) {
  const std::filesystem::path& database = command.files.back();
  const bool is_server = database::is_server_name(database.string());
  const CloudInputs files =
      resolve_clouds(std::span(command.files).first(command.files.size() - 1), cloud_formats());
  Store store;
  std::string place;
  if (is_server) {
    const database::ServerName name = server_name(command);
    place = name.shown();
    store = [&, name](const CloudInputs& some, const ReadOptions& reading, const Progress& storing) {
      return database::store_on_server(name, some, reading,
                                       {command.store.replace, command.load.memory, storing});
    };
  } else {
    check_name(database);
    // A database that is there stays: what may be replaced is a table in it.
    check_writable(database, true, files.names());
    place = fmt::format("table {} of {}", command.store.table, database.string());
    store = [&](const CloudInputs& some, const ReadOptions& reading, const Progress& storing) {
      database::StoreOptions options = command.store;
      options.memory = command.load.memory;
      options.progress = storing;
      return database::store_files(database, some, reading, options);
    };
  }
  std::uint64_t count = 0;
  load_with_progress(command.load, "storing", [&](const ReadOptions& reading, const Progress& storing) {
    database::StoredFiles stored = store(files, reading, storing);
    count = stored.point_count;
    return std::move(stored.warnings);
  });
  say_note(command.load.verbosity, fmt::format("{} points are {}", count, place));
  return ExitCode::done;
}

struct ShardPlanCommand {
  CloudInputs files;
  std::filesystem::path output;
  std::vector<database::Shard> shards;
  std::string table = "points";
  LoadOptions load;
};

ExitCode run(const ShardPlanCommand& command) {
  std::uint64_t count = 0;
  load_with_progress(command.load, "writing", [&](const ReadOptions& reading, const Progress& writing) {
    database::StoredFiles plan = database::write_shard_plan(
        command.output, command.files, reading, command.shards,
        {.table = command.table, .memory = command.load.memory, .progress = writing});
    count = plan.point_count;
    return std::move(plan.warnings);
  });
  if (command.load.verbosity != Verbosity::quiet) {
    say_note(fmt::format("{} points for {} shards in {}; {} tells what to type", count, command.shards.size(),
                         command.output.string(), (command.output / "README.txt").string()));
  }
  return ExitCode::done;
}

}  // namespace

Command add_sql_load(const Options& sql) {
  auto command = std::make_shared<LoadCommand>();
  const Options load = sql.command("load", "Store a cloud in a database");
  load.words("files", "FILE... DB",
             "cloud files, folders or patterns as 'tiles/*.las', taken together as one; then the database, "
             "SQLite's file, which is made if it is not there, or 'postgresql://HOST/DATABASE?table=NAME'",
             [command](const std::vector<std::string>& words) {
               command->files.assign(words.begin(), words.end());
             })
      .at_least(2)
      .required();
  load.text("--table", "NAME", "what SQL calls the cloud (default: points)", command->store.table);
  load.count("--chunk-points", "N", "points that SQLite reads together, 1 to 65536 (default: 1024)",
             command->store.chunk_points, 1, 65536);
  load.flag("--overwrite", "replace a table of that name, if it is a cloud", command->store.replace);
  add_load_options(load, command->load);
  return {load, [command] { return with_threads(command->load.threads, [&] { return run(*command); }); }};
}

Command add_sql_shard_plan(const Options& sql) {
  auto command = std::make_shared<ShardPlanCommand>();
  const Options plan = sql.command("shard-plan", "Write what puts a cloud on several PostgreSQL servers");
  add_cloud_files(plan, "files", "FILE...",
                  "cloud files, folders or patterns as 'tiles/*.las', taken together as one", command->files)
      .required();
  plan.file("-o,--output", "FOLDER", "folder to make", command->output).required();
  plan.words("--shard", "HOST[:PORT]/DATABASE...",
             "databases that take a part of the points each, equally many; port 5432 if none is given. Users "
             "and passwords belong to the servers' user mappings, not here",
             [command](const std::vector<std::string>& words) {
               command->shards.clear();
               for (const std::string& word : words) command->shards.push_back(database::parse_shard(word));
             })
      .required();
  plan.text("--table", "NAME", "what SQL calls the cloud (default: points)", command->table);
  add_load_options(plan, command->load);
  return {plan, [command] { return with_threads(command->load.threads, [&] { return run(*command); }); }};
}

}  // namespace alidade::tools
