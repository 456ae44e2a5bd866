// SPDX-License-Identifier: MIT
#include "database/server/server_clouds.h"

#include <fmt/format.h>

#include <array>

#include "base/scratch_file.h"
#include "database/point_stream.h"
#include "database/server/copy_format.h"
#include "database/server/server_connection.h"
#include "database/server/server_sql.h"
#include "database/sql_name.h"

namespace alidade::database {
namespace {

/// The quoted names of the objects of a cloud.
struct CloudTables {
  std::string schema, points, cloud;
};

bool has_relation(ServerConnection& connection, const std::string& schema, const std::string& name) {
  const std::array<std::string, 2> names = {schema, name};
  const ServerRows found = connection.run(
      "SELECT 1 FROM pg_catalog.pg_class c JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace"
      " WHERE n.nspname::text = $1::text AND c.relname::text = $2::text",
      names);
  return found.size() > 0;
}

/// Errors: an object of such a name exists that must not be replaced.
CloudTables check_tables(ServerConnection& connection, const ServerName& name, bool replace) {
  std::string schema = name.schema;
  if (schema.empty()) schema = connection.run("SELECT current_schema()").text(0, 0);
  if (schema.empty()) connection.fail("empty search path", "one in the name, as &schema=public");
  const bool has_points = has_relation(connection, schema, name.table);
  const bool has_cloud = has_relation(connection, schema, name.table + "_cloud");
  if (has_points && !(replace && has_cloud)) {
    connection.fail(
        fmt::format("the table {} exists", name.table),
        replace ? "a cloud with the table " + name.table + "_cloud" : "another name, or --overwrite");
  }
  if (has_cloud && !has_points)
    connection.fail(fmt::format("the table {}_cloud exists", name.table), "another name");
  return {.schema = schema,
          .points = sql_name(schema) + "." + sql_name(name.table),
          .cloud = sql_name(schema) + "." + sql_name(name.table + "_cloud")};
}

/// Stores a cloud within a transaction.
void store(ServerConnection& connection, const ServerName& name, OrderedCloud& cloud,
           const ServerStoreOptions& options) {
  std::uint64_t done = 0;
  const ServerWait wait = [&] { report(options.progress, done, cloud.points.size()); };
  const CopyRows rows(cloud.columns(), cloud.whole.rest.lattice);
  check_column_count(rows.columns());
  connection.run("CREATE EXTENSION IF NOT EXISTS alidade_pg");
  // Another session may have made a table meanwhile.
  const CloudTables tables = check_tables(connection, name, options.replace);
  if (options.replace)
    connection.run("DROP TABLE IF EXISTS " + tables.points + ", " + tables.cloud, {}, wait);
  connection.run("CREATE TABLE " + tables.points + "(" + server_columns(rows.columns()) +
                 ", CONSTRAINT has_place CHECK (x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND"
                 " y < 'Infinity' AND z > '-Infinity' AND z < 'Infinity'))");
  connection.begin_copy_in("COPY " + tables.points + " FROM STDIN (FORMAT binary)");
  const Bounds box =
      rows.copy(cloud, cloud.points.size(), [&](std::span<const std::byte> bytes, std::size_t count) {
        connection.put(bytes, wait);
        done += count;
        wait();
      });
  connection.end_copy_in(wait);
  connection.run(server_index(tables.points), {}, wait);
  connection.run(cloud_row_table(tables.cloud));
  connection.run(cloud_row_insert(tables.cloud, cloud_row(cloud.whole, box)));
  connection.run("ANALYZE " + tables.points, {}, wait);
  connection.run("COMMIT", {}, wait);
}

}  // namespace

StoredFiles store_on_server(const ServerName& name, const CloudInputs& inputs, const ReadOptions& reading,
                            const ServerStoreOptions& options) {
  if (name.table.empty()) throw file_error(name.shown(), "missing table name", "?table=NAME at the end");
  check_server_table(name.table);
  ServerConnection connection(name);
  check_tables(connection, name, options.replace);

  OrderedCloud cloud(temporary_folder(), inputs, reading, options.memory);
  connection.run("BEGIN");
  store(connection, name, cloud, options);
  return std::move(cloud).stored();
}

}  // namespace alidade::database
