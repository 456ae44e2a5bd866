// SPDX-License-Identifier: MIT
#include "tools/sql_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "database/sqlite/store_cloud.h"
#include "octree/cloud/cloud_files.h"
#include "tools/cloud_options.h"
#include "tools/message.h"
#include "tools/options.h"
#include "tools/parse_size.h"
#include "visibility/file_ending.h"

namespace alidade {
namespace {

struct LoadCommand {
  std::vector<std::filesystem::path> files;  ///< the last one is the database
  bool partial = false;
  std::optional<ColorDepth> color_depth;
  StoreOptions store;
  std::optional<int> threads;
  VerbosityOptions verbosity;
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

/// Reads and stores, each with a progress line of its own.
StoredFiles store(const std::filesystem::path& database, std::span<const std::filesystem::path> files,
                  const LoadCommand& command) {
  const Verbosity verbosity = command.verbosity.verbosity();
  ProgressLine reading("reading", "B", verbosity);
  std::optional<ProgressLine> storing;
  Progress store_progress;
  StoreOptions options = command.store;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    if (!storing) {
      reading.finish();
      storing.emplace("storing", "points", verbosity);
      store_progress = storing->callback();
    }
    return store_progress(done, total);
  };
  const StoredFiles stored = store_files(database, files,
                                         {.color_depth = command.color_depth.value_or(ColorDepth::automatic),
                                          .partial = command.partial,
                                          .progress = reading.callback()},
                                         options);
  storing->finish();
  return stored;
}

ExitCode run(const LoadCommand& command) {
  const std::filesystem::path& database = command.files.back();
  const auto names = std::span(command.files).first(command.files.size() - 1);
  check_name(database);
  const std::vector<std::filesystem::path> files = expand_cloud_files(names);
  // A database that is there stays: what may be replaced is a table in it.
  check_writable(database, true, files);
  const StoredFiles stored = store(database, files, command);
  if (command.verbosity.quiet) return ExitCode::done;
  for (const std::string& warning : stored.warnings) say_warning(warning);
  say_note(fmt::format("{} points are table {} of {}", stored.point_count, command.store.table,
                       database.string()));
  return ExitCode::done;
}

}  // namespace

Command add_sql_load(CLI::App& sql) {
  auto command = std::make_shared<LoadCommand>();
  CLI::App* const load = sql.add_subcommand("load", "Store a cloud in an SQLite database");
  load->add_option(
          "files", command->files,
          "cloud files, folders or patterns as 'tiles/*.las', taken together as one; then the database, "
          "which is made if it is not there")
      ->option_text("FILE... DB")
      ->expected(2, -1)
      ->required();
  load->add_option("--table", command->store.table, "what SQL calls the cloud (default: points)")
      ->option_text("NAME");
  add_value(*load, "--chunk-points", "N", "points that are read together, 1 to 65536 (default: 1024)",
            [command](const std::string& text) {
              command->store.chunk_points = static_cast<std::uint32_t>(parse_count(text, 1, 65536));
            });
  load->add_flag("--overwrite", command->store.replace, "replace a table of that name, if it is a cloud");
  add_value(
      *load, "--memory", "SIZE",
      "for points while they are sorted: bytes, or a number with k, M, G or T (default: 1G); those of a "
      "larger cloud wait in a hidden file beside the database",
      [command](const std::string& text) {
        constexpr std::size_t k_least = std::size_t{1} << 20;
        command->store.memory = parse_size(text);
        if (command->store.memory < k_least)
          throw CLI::ValidationError("expected at least 1M, found '" + text + "'");
      });
  add_choice<ColorDepth>(*load, "--color-depth",
                         "bits in use of LAS colours (default: 8 if none exceeds 255); 16 are stored",
                         command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(*load, command->partial);
  add_threads(*load, command->threads);
  add_verbosity(*load, command->verbosity);
  load->footer(
      "Form:\n"
      "  alidade sql load FILE... DB [OPTIONS]\n"
      "\n"
      "The table has a column for every attribute; its ids are the rows of the cloud files. Points lie along "
      "a "
      "Morton\n"
      "curve in chunks, of which a condition on distances leaves most unread. A database can hold many "
      "clouds. "
      "The table\n"
      "is there as a whole or not at all, and so is a new database.\n"
      "\n"
      "Examples:\n"
      "  alidade sql load site.las site.db\n"
      "  alidade sql load tiles/ site.db --table tiles --memory 4G\n");
  return {load, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade
