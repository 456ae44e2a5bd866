// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "octree/cloud/cloud_database.h"

namespace alidade {

/// "site.db", a file, or "site.db?table=NAME", a table of its; without a name it must be the only cloud in
/// the file.
struct SqliteCloudName {
  std::string file, table;

  explicit SqliteCloudName(const std::string& name);
};

/// Clouds that store_cloud() wrote, for add_cloud_database(): points come back in the rows they had, with all
/// attributes. Errors when opened: the file is no database; it has no cloud, several, or none of the name;
/// read_cloud_schema()'s. When read: ChunkStore's; ids that are no rows.
CloudDatabase sqlite_clouds();

}  // namespace alidade
