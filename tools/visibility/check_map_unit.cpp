// SPDX-License-Identifier: MIT
#include "tools/visibility/check_map_unit.h"

#include "base/error.h"
#include "geo/map_unit.h"

namespace alidade {

void check_map_unit(const PointCloud& cloud) {
  if (map_unit(cloud.crs) != MapUnit::degree) return;
  throw Error({.file = cloud.files.empty() ? "" : cloud.files.front().path.string(),
               .problem = "x and y are degrees, over which nothing has an elevation",
               .expected = "a cloud in a projected reference system"});
}

}  // namespace alidade
