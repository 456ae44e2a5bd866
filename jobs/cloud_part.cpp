// SPDX-License-Identifier: MIT
#include "jobs/cloud_part.h"

#include "database/server/server_clouds.h"
#include "database/sqlite/stored_cloud.h"

namespace alidade::jobs {

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

}  // namespace alidade::jobs
