// SPDX-License-Identifier: MIT
#include "jobs/load_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "jobs/large_clouds.h"
#include "octree/spacing.h"
#include "surface/point_surface.h"

namespace alidade::jobs {

PointCloud read_files(const CloudInputs& files, bool partial, ReadOptions options, Listener& listener) {
  options.partial = partial;
  PointCloud cloud = in_stage(listener, "reading", "B", [&](const Progress& progress) {
    options.progress = progress;
    return read_cloud(files, options);
  });
  warn_all(listener, cloud.warnings);
  return cloud;
}

IndexedCloud load_cloud(const CloudInputs& files, bool partial, IndexCloudOptions options,
                        Listener& listener) {
  options.read.partial = partial;
  if (large_clouds() != nullptr) options.read_large = large_clouds()->read;
  IndexedCloud cloud = in_stage(listener, "loading cloud", "B", [&](const Progress& progress) {
    options.read.progress = progress;
    return load_indexed_cloud(files, options);
  });
  warn_all(listener, cloud.cloud.warnings);
  return cloud;
}

database::StoredFiles store_in_stages(const CloudInputs& files, ReadOptions options, std::uint64_t memory,
                                      const std::string& storing, const OpenStore& output,
                                      Listener& listener) {
  const std::unique_ptr<Listener::Stage> reading = listener.begin("reading", "B");
  options.progress = reading->callback();
  database::OrderedCloud cloud(output.folder, files, options, memory);
  reading->finish();
  in_stage(listener, storing, "points", [&](const Progress& progress) { output.store(cloud, progress); });
  warn_all(listener, cloud.whole.rest.warnings);
  return std::move(cloud).stored();
}

Octree with_spacings(const Octree& octree, int neighbours, Listener& listener) {
  return in_stage(listener, "measuring spacings", "points", [&](const Progress& progress) {
    return alidade::with_spacings(octree, neighbours, progress);
  });
}

Octree with_surfaces(const Octree& octree, Listener& listener) {
  return in_stage(listener, "fitting surfaces", "points",
                  [&](const Progress& progress) { return alidade::with_surfaces(octree, progress); });
}

void check_map_unit(const Crs& crs, const CloudInputs& clouds) {
  if (!is_geographic(crs)) return;
  throw file_error(clouds.title(), "geographic coordinates (degrees) are not supported",
                   "a projected reference system: --reproject auto, or --reproject EPSG:n", crs_name(crs));
}

}  // namespace alidade::jobs
