// SPDX-License-Identifier: MIT
// index_seeds FOLDER: small index files of every organisation, with and without attributes, ids and exact
// positions and spacings, as a start for fuzz_index.
#include <filesystem>
#include <string>

#include "octree/build.h"
#include "octree/index_file/save_index.h"
#include "octree/spacing.h"
#include "surface/point_surface.h"

namespace {

using namespace alidade;

PointCloud cloud_of(std::int32_t count, std::int32_t step) {
  PointCloud cloud;
  for (std::int32_t i = 0; i < count; ++i)
    cloud.positions.emplace_back(i * step % 1009, i * i % 4001, i % 7 == 0 ? i * step * 3 : 5);
  return cloud;
}

void add_attributes(PointCloud& cloud) {
  cloud.colors.resize(cloud.size(), Color16(1, 2, 3));
  cloud.gps_times.resize(cloud.size(), 0.5);
  ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
  dimension.name = "extra";
  dimension.values.resize(8 * cloud.size());
  cloud.crs.wkt = "LOCAL_CS[\"seed\"]";
  cloud.files.push_back({.path = "seed.las",
                         .format = "LAS",
                         .version = "1.4",
                         .point_format = 7,
                         .point_count = cloud.size()});
  cloud.warnings.emplace_back("seed.las: is a seed");
  cloud.records.push_back({"seed", 1, "a record", {1, 2, 3}, false});
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  int number = 0;
  const auto save = [&](const Octree& octree, const PointCloud& cloud) {
    save_index(folder / ("seed_" + std::to_string(number++)), octree, cloud, {.overwrite = true});
  };
  save(build(PointCloud()), PointCloud());
  for (const std::int32_t points : {1, 40, 700}) {
    for (const Organisation organisation :
         {Organisation::adaptive, Organisation::fixed, Organisation::layered}) {
      BuildOptions options;
      options.organisation = organisation;
      options.leaf_size = 8;
      // Steps of 2000 spread the points so far that some have exact positions.
      for (const std::int32_t step : {3, 2000}) {
        const PointCloud cloud = cloud_of(points, step);
        save(build(cloud, options), cloud);
        save(with_spacings(build(cloud, options), 3), cloud);
        save(with_surfaces(with_spacings(build(cloud, options), 8)), cloud);
      }
    }
  }
  PointCloud cloud = cloud_of(100, 5);
  add_attributes(cloud);
  save(build(cloud), cloud);
  save(build_in_stored_order(cloud), cloud);
}
