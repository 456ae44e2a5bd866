// SPDX-License-Identifier: MIT
#include "jobs/sql/load.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "cloud/catalog.h"
#include "database/sqlite/store_cloud.h"
#include "database/sqlite/stored_cloud.h"
#include "jobs/cloud_fields.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

constexpr std::size_t k_memory = std::size_t{1} << 30;

/// Errors: the database has the name of a cloud: it was probably forgotten.
void check_name(const std::filesystem::path& database) {
  if (!is_catalog_name(database.string()) &&
      !has_extension(database, {".las", ".laz", ".ply", ".pcd", ".e57", ".pts", ".ptx", ".xyz", ".csv",
                                ".alidade", ".parquet"}))
    return;
  throw file_error(database, "the database name is that of a cloud file",
                   "the database as the last name, such as site.db");
}

/// The extension's output that the request names; null: an SQLite file.
const CloudStore* database_of(const LoadRequest& request) {
  return store_of(request.stores, request.output, false);
}

StoreTarget target_of(const LoadRequest& request) {
  const bool is_default = request.table == StoreRequest().table;
  return {request.output, is_default ? "" : request.table, request.overwrite};
}

database::StoreOptions sqlite_options(const LoadRequest& request) {
  database::StoreOptions options{.table = request.table, .replace = request.overwrite};
  options.chunk_points = request.chunk_points.value_or(options.chunk_points);
  return options;
}

OpenStore open_sqlite(const LoadRequest& request) {
  return {request.output.parent_path(), [output = request.output, options = sqlite_options(request)](
                                            database::OrderedCloud& cloud, const Progress& progress) mutable {
            options.progress = progress;
            database::store_cloud(output, cloud, options);
          }};
}

/// The forms of databases that are not SQLite files, for the help.
std::string forms_of(const CloudStores& stores) {
  std::string text;
  for (const auto& store : stores) {
    if (!store->is_file()) text += fmt::format(", or '{}'", store->form());
  }
  return text;
}

}  // namespace

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

void add_load_fields(const Fields& fields, LoadRequest& request) {
  const CloudView view = add_view_fields(fields);
  fields.required().words(
      "files", "FILE... DB",
      "cloud files, folders, catalogs or patterns such as 'tiles/*.las', joined into one cloud; then the "
      "database, an SQLite file, created if missing" +
          forms_of(request.stores),
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

LoadPlan plan(const LoadRequest& request) {
  std::string database = request.output.string();
  if (const CloudStore* const store = database_of(request)) {
    database = store->check(target_of(request));
    if (request.chunk_points)
      throw file_error(database, "--chunk-points does not apply to servers", "no --chunk-points");
  } else {
    check_name(request.output);
    if (database::k_sqlite_format.is_named(database))
      throw file_error(database, "the database name has a table", "--table NAME behind the name of the file");
    // An existing database stays: `overwrite` replaces a table in it.
    if (!request.overwrite) check_links(request.output);
    check_writable(request.output, true, request.files.names());
    database::check_store(request.output, sqlite_options(request));
  }
  return LoadPlan(request, {.clouds = request.files, .partial = request.partial, .writes = {database}});
}

database::StoredFiles run(const LoadPlan& plan, Listener& listener) {
  const LoadRequest& request = plan.request();
  const CloudStore* const store = database_of(request);
  const database::StoredFiles stored =
      store_in_stages(request, "storing",
                      store != nullptr ? store->open(target_of(request)) : open_sqlite(request), listener);
  listener.note(fmt::format("stored {} points as {}", stored.point_count,
                            store != nullptr
                                ? store->check(target_of(request))
                                : fmt::format("table {} of {}", request.table, request.output.string())));
  return stored;
}

database::StoredFiles store_in_stages(const StoreRequest& request, const std::string& storing,
                                      const OpenStore& output, Listener& listener) {
  return store_in_stages(request.files, {.color_depth = request.color_depth, .partial = request.partial},
                         request.memory.value_or(k_memory), storing, output, listener);
}

}  // namespace alidade::jobs
