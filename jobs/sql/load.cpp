// SPDX-License-Identifier: MIT
#include "jobs/sql/load.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "cloud/catalog.h"
#include "database/server/server_clouds.h"
#include "database/sqlite/store_cloud.h"
#include "jobs/cloud_fields.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

constexpr std::size_t k_memory = std::size_t{1} << 30;

void add_table(const Fields& fields, StoreRequest& request) {
  fields.text("--table", "NAME", "table name of the cloud (default: points)", request.table);
}

void add_storing(const Fields& fields, StoreRequest& request) {
  fields.value("--memory", "SIZE",
               "memory for sorting points: bytes, or a number with k, M, G or T (default: 1G); points of a "
               "larger cloud use a temporary file next to the output",
               request.memory, parse_memory);
  fields.choice("--color-depth",
                "bits in use of LAS colours (default: 8 if none exceeds 255); the database stores 16",
                request.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_partial(fields, request.partial);
}

/// Errors: the database has the name of a cloud: it was probably forgotten.
void check_name(const std::filesystem::path& database) {
  if (!is_catalog_name(database.string()) &&
      !has_extension(database, {".las", ".laz", ".ply", ".pcd", ".e57", ".pts", ".ptx", ".xyz", ".csv",
                                ".alidade", ".parquet"}))
    return;
  throw file_error(database, "the database name is that of a cloud file",
                   "the database as the last name, such as site.db");
}

/// The table on the server. Errors: it is named twice; fields for SQLite only.
database::ServerName server_name(const LoadRequest& request) {
  database::ServerName name(request.output.string());
  const bool is_named_twice = !name.table.empty() && request.table != StoreRequest().table;
  if (is_named_twice) throw file_error(name.shown(), "duplicate table name", "?table= or --table");
  if (request.chunk_points)
    throw file_error(name.shown(), "--chunk-points does not apply to servers", "no --chunk-points");
  if (name.table.empty()) name.table = request.table;
  return name;
}

}  // namespace

void add_load_fields(const Fields& fields, LoadRequest& request) {
  const CloudView view = add_view_fields(fields);
  fields.required().words(
      "files", "FILE... DB",
      "cloud files, folders, catalogs or patterns such as 'tiles/*.las', joined into one cloud; then the "
      "database, an SQLite file, created if missing, or 'postgresql://HOST/DATABASE?table=NAME'",
      [&request, view](const std::vector<std::string>& words) {
        const std::vector<std::filesystem::path> files(words.begin(), words.end() - 1);
        request.files = view.apply(resolve_clouds(files, cloud_formats()));
        request.output = words.back();
      },
      2);
  add_table(fields, request);
  fields.count("--chunk-points", "N", "points per chunk of SQLite, 1 to 65536 (default: 1024)",
               request.chunk_points, 1, 65536);
  fields.flag("--overwrite", "replace an existing cloud of that name", request.overwrite);
  add_storing(fields, request);
}

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

LoadPlan plan(const LoadRequest& request) {
  CheckedLoad checked{request, {}};
  if (database::is_server_name(request.output.string())) {
    checked.server = server_name(request);
  } else {
    check_name(request.output);
    // An existing database stays: `overwrite` replaces a table in it.
    if (!request.overwrite) check_links(request.output);
    check_writable(request.output, true, request.files.names());
  }
  const std::string database = checked.server ? checked.server->shown() : request.output.string();
  return LoadPlan(std::move(checked),
                  {.clouds = request.files, .partial = request.partial, .writes = {database}});
}

ShardPlanPlan plan(const ShardPlanRequest& request) {
  database::check_shard_plan(request.output, request.table);
  return ShardPlanPlan(request,
                       {.clouds = request.files, .partial = request.partial, .writes = {request.output}});
}

database::StoredFiles run(const LoadPlan& plan, Listener& listener) {
  const CheckedLoad& request = plan.request();
  const ReadOptions reading{.color_depth = request.color_depth, .partial = request.partial};
  database::StoredFiles stored =
      store_in_stages(reading, "storing", listener, [&](const ReadOptions& read, const Progress& storing) {
        if (request.server)
          return database::store_on_server(*request.server, request.files, read,
                                           {request.overwrite, request.memory.value_or(k_memory), storing});
        return database::store_files(
            request.output, request.files, read,
            {request.table, request.chunk_points.value_or(database::StoreOptions().chunk_points),
             request.overwrite, request.memory.value_or(k_memory), storing});
      });
  listener.note(fmt::format("stored {} points as {}", stored.point_count,
                            request.server
                                ? request.server->shown()
                                : fmt::format("table {} of {}", request.table, request.output.string())));
  return stored;
}

database::StoredFiles run(const ShardPlanPlan& plan, Listener& listener) {
  const ShardPlanRequest& request = plan.request();
  const ReadOptions reading{.color_depth = request.color_depth, .partial = request.partial};
  database::StoredFiles stored =
      store_in_stages(reading, "writing", listener, [&](const ReadOptions& read, const Progress& writing) {
        return database::write_shard_plan(
            request.output, request.files, read, request.shards,
            {.table = request.table, .memory = request.memory.value_or(k_memory), .progress = writing});
      });
  listener.note(fmt::format("planned {} points for {} shards in {}; {} lists the commands",
                            stored.point_count, request.shards.size(), request.output.string(),
                            (request.output / "README.txt").string()));
  return stored;
}

}  // namespace alidade::jobs
