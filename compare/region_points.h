// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"
#include "compare/change_regions.h"

// From pixels back to points: what was there, and what is there now.

namespace alidade::compare {

/// A point that a region shows.
struct RegionPoint {
  std::uint32_t id = 0;      ///< row in the cloud
  std::uint32_t region = 0;  ///< 1 + position in ChangeRegions::regions
  bool operator==(const RegionPoint&) const = default;
};

/// The points that the regions show, each once (in the largest region that shows it), by id. `ids` is the id
/// layer of one of the two pictures: point id + 1, 0 where there is nothing. The reference's ids are rows of
/// the reference's cloud, the test's of the test's. Objects of a scene, which count down from 4294967295, are
/// no points. Errors: an id beyond `point_count` that cannot be an object of a scene, so the picture was made
/// of another cloud; a layer that is not of the map's size. Cost: a sort of the changed pixels.
std::vector<RegionPoint> region_points(std::span<const std::uint32_t> ids, const ChangeRegions& changes,
                                       std::uint64_t point_count);

/// These points of the cloud with all their attributes, scale, offset, reference system and records, and the
/// number of the region in an extra dimension Region (uint32, from 1), which replaces one of that
/// name. Memory: a copy of these points.
PointCloud points_of_regions(const PointCloud& cloud, std::span<const RegionPoint> points);

}  // namespace alidade::compare
