// SPDX-License-Identifier: MIT
#include "tools/cloud/load_cloud.h"

#include <fmt/format.h>

#include "base/error.h"
#include "database/server/server_clouds.h"
#include "database/sqlite/stored_cloud.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade::tools {

IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options) {
  Console console(request.verbosity);
  return jobs::load_cloud(request.files, request.partial, std::move(options), console);
}

bool has_parts(const CloudInput& input) {
  if (input.is_changed()) return false;
  const bool has_parts = input.is(database::k_server_format) ? database::has_server_parts(input.name.string())
                                                             : input.is(database::k_sqlite_format);
  return has_parts && !input.changes_heights();
}

const char* part_unit(const CloudInput& input) {
  return input.is(database::k_server_format) ? "points" : "chunks";
}

database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress) {
  const auto read =
      input.is(database::k_server_format) ? database::read_server_part : database::read_cloud_part;
  return read(input.name.string(), any_of, attributes, progress);
}

std::string part_table(const database::CloudPart& part) {
  if (part.chunk_count == 0) return fmt::format("{:<22}{:>16}\n", "points read", part.ids.size());
  const double share = 100.0 * static_cast<double>(part.chunks_read) / static_cast<double>(part.chunk_count);
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", part.chunks_read, share);
}

}  // namespace alidade::tools
