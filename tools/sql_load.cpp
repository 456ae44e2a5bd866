// SPDX-License-Identifier: MIT
#include "tools/sql_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "database/sqlite/store_cloud.h"
#include "octree/cloud/cloud_files.h"
#include "tools/load_options.h"
#include "tools/message.h"
#include "visibility/file_ending.h"

namespace alidade {
namespace {

struct LoadCommand {
  std::vector<std::filesystem::path> files;  ///< the last one is the database
  StoreOptions store;
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

ExitCode run(const LoadCommand& command) {
  const std::filesystem::path& database = command.files.back();
  const auto names = std::span(command.files).first(command.files.size() - 1);
  check_name(database);
  const std::vector<std::filesystem::path> files = expand_cloud_files(names);
  // A database that is there stays: what may be replaced is a table in it.
  check_writable(database, true, files);
  std::uint64_t count = 0;
  load_with_progress(command.load, "storing", [&](const ReadOptions& reading, const Progress& storing) {
    StoreOptions options = command.store;
    options.memory = command.load.memory;
    options.progress = storing;
    StoredFiles stored = store_files(database, files, reading, options);
    count = stored.point_count;
    return std::move(stored.warnings);
  });
  if (!command.load.verbosity.quiet)
    say_note(fmt::format("{} points are table {} of {}", count, command.store.table, database.string()));
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
  add_load_options(*load, command->load);
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
            with_threads(command->load.threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade
