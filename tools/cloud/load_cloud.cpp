// SPDX-License-Identifier: MIT
#include "tools/cloud/load_cloud.h"

#include <fmt/format.h>

#include "cloud/cloud_inputs.h"
#include "database/server/read_server.h"
#include "database/server/server_name.h"
#include "database/sqlite/stored_cloud.h"

namespace alidade::tools {

bool has_parts(const std::filesystem::path& name) {
  return database::is_server_name(name.string()) ? database::has_server_parts(name.string())
                                                 : lies_in_database(name);
}

const char* part_unit(const std::filesystem::path& name) {
  return database::is_server_name(name.string()) ? "points" : "chunks";
}

database::CloudPart read_database_part(const std::filesystem::path& name,
                                       std::span<const database::PointFilter> any_of, AttributeSet attributes,
                                       const Progress& progress) {
  if (database::is_server_name(name.string()))
    return database::read_server_part(name.string(), any_of, attributes, progress);
  return database::read_cloud_part(name.string(), any_of, attributes, progress);
}

std::string part_table(const database::CloudPart& part) {
  if (part.chunk_count == 0) return fmt::format("{:<22}{:>16}\n", "points read", part.ids.size());
  const double share = 100.0 * static_cast<double>(part.chunks_read) / static_cast<double>(part.chunk_count);
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", part.chunks_read, share);
}

}  // namespace alidade::tools
