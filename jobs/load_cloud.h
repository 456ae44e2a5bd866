// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "cloud/crs.h"
#include "cloud/read_cloud.h"
#include "jobs/cloud_formats.h"
#include "jobs/listener.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// Reads the files of a cloud, or loads them with an octree, each as one stage; warns of what the cloud warns
/// of. `partial`: damaged files are read in part; that, and `progress` and `read_large` of the options, are
/// ignored.
PointCloud read_files(const CloudInputs& files, bool partial, ReadOptions options, Listener& listener);
IndexedCloud load_cloud(const CloudInputs& files, bool partial, IndexCloudOptions options,
                        Listener& listener);

/// Reads files and then stores their points: two stages, the second one called `storing`; warns of what the
/// cloud warns of. `memory`: bytes for points. `progress` of the options is ignored.
database::StoredFiles store_in_stages(const CloudInputs& files, ReadOptions options, std::uint64_t memory,
                                      const std::string& storing, const OpenStore& output,
                                      Listener& listener);

/// with_spacings() and with_surfaces(), each as one stage.
Octree with_spacings(const Octree& octree, int neighbours, Listener& listener);
Octree with_surfaces(const Octree& octree, Listener& listener);

/// Errors: x and y of a cloud are degrees, and z is a length: distances are undefined, so that images would
/// be hairlines and answers about sight wrong.
void check_map_unit(const Crs& crs, const CloudInputs& clouds);

}  // namespace alidade::jobs
