// SPDX-License-Identifier: MIT
#include "tools/cloud/cloud_description.h"

namespace alidade {

PointCloud description_of(const IndexedCloud& cloud) {
  PointCloud description;
  description.lattice = cloud.octree.lattice();
  description.crs = cloud.cloud.crs;
  description.records = cloud.index ? cloud.index->records() : cloud.cloud.records;
  description.gps_time_is_standard = cloud.cloud.gps_time_is_standard;
  description.project_id = cloud.cloud.project_id;
  description.file_source_id = cloud.cloud.file_source_id;
  return description;
}

}  // namespace alidade
