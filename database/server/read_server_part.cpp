// SPDX-License-Identifier: MIT
#include "database/server/read_server_part.h"

#include <fmt/format.h>

#include <algorithm>

#include "cloud/rows.h"
#include "database/server/filter_condition.h"
#include "database/server/server_cloud.h"

namespace alidade {
namespace {

constexpr std::size_t k_most_filters = 64;

/// The condition for the server; none if it cannot help.
std::string condition(ServerConnection& connection, std::span<const PointFilter> any_of) {
  if (any_of.size() > k_most_filters) return {};
  // The functions' schema need not be on the search path; all conditions are met where there are none.
  const ServerRows schema = connection.run(
      "SELECT quote_ident(n.nspname) FROM pg_catalog.pg_extension e"
      " JOIN pg_catalog.pg_namespace n ON n.oid = e.extnamespace WHERE e.extname = 'alidade_pg'");
  if (schema.size() == 0) return {};
  const std::string name = schema.text(0, 0);
  connection.run("SELECT set_config('search_path', current_setting('search_path') || ', ' || $1::text, true)",
                 std::span(&name, 1));
  return filter_condition(any_of);
}

}  // namespace

bool has_server_parts(const std::string& name) {
  return ServerCloud(ServerName(name)).table().cloud.has_value();
}

CloudPart read_server_part(const std::string& name, std::span<const PointFilter> any_of,
                           AttributeSet attributes, const Progress& progress) {
  ServerCloud server((ServerName(name)));
  const CloudRow& row_of_cloud = server.table().cloud.value();
  const std::vector<ValueColumn> columns = value_columns(server.table(), true);
  CloudPart part;
  part.attributes = attributes_of(columns);
  const AttributeSet kept = part.attributes & attributes;
  part.cloud.lattice = row_of_cloud.lattice;
  part.cloud.crs = row_of_cloud.crs;
  part.cloud.gps_time_is_standard = row_of_cloud.gps_time_is_standard;
  const RowChoice choice{.columns = kept_columns(columns, kept),
                         .has_ids = true,
                         .is_sorted = true,
                         .condition = condition(server.connection(), any_of)};
  CloudValues values(part.cloud, choice.columns);
  const ServerWait wait = [&] {
    report(progress, part.ids.size(), std::max<std::uint64_t>(row_of_cloud.point_count, 1));
  };
  server.read(
      choice,
      [&](const ServerRow& row) {
        const auto id = static_cast<std::uint64_t>(row.id);
        if (id >= row_of_cloud.point_count || (!part.ids.empty() && id <= part.ids.back())) {
          server.connection().fail("ids are not the numbers of the rows",
                                   fmt::format("each number below {} once", row_of_cloud.point_count),
                                   std::to_string(row.id));
        }
        const auto position = to_lattice(row_of_cloud.lattice, row.world);
        if (!position)
          server.connection().fail("a point does not fit on the lattice", {}, {}, fmt::format("id {}", id));
        const std::size_t place = part.ids.size();
        if (place == part.cloud.size()) {
          append_rows(part.cloud, kept, std::max<std::size_t>(place, 4096));
          values.find_columns();
          wait();
        }
        part.ids.push_back(id);
        part.cloud.positions[place] = *position;
        values.put(place, row.values, [&] { return fmt::format("id {}", id); });
      },
      wait);
  part.cloud.resize(part.ids.size());
  report(progress, part.ids.size(), part.ids.size());
  CloudFile& file = part.cloud.files.emplace_back();
  file.path = server.connection().name();
  file.format = "PostgreSQL";
  file.version = std::to_string(k_cloud_row_version);
  file.point_count = part.ids.size();
  return part;
}

}  // namespace alidade
