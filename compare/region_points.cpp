// SPDX-License-Identifier: MIT
#include "compare/region_points.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

#include "base/error.h"
#include "cloud/point_cloud.h"
#include "cloud/rows.h"

namespace alidade::compare {
namespace {

constexpr const char* k_region_name = "Region";

/// Objects of a scene are numbered from the other end; no scene has as many.
constexpr std::uint32_t k_first_object_id = 0xff000000u;

ExtraDimension region_dimension() {
  ExtraDimension dimension;
  dimension.name = k_region_name;
  dimension.description = "changed region, 1 is largest";
  dimension.type = ScalarType::uint32;
  dimension.byte_count = 4;
  return dimension;
}

}  // namespace

std::vector<RegionPoint> region_points(std::span<const std::uint32_t> ids, const ChangeRegions& changes,
                                       std::uint64_t point_count) {
  check_that(ids.size() == changes.labels.size(), "the id layer and the change map differ in size",
             std::to_string(changes.labels.size()) + " pixels", std::to_string(ids.size()));
  std::vector<RegionPoint> points;
  for (std::size_t pixel = 0; pixel < ids.size(); ++pixel) {
    if (changes.labels[pixel] == 0 || ids[pixel] == 0) continue;
    if (ids[pixel] > point_count) {
      if (ids[pixel] >= k_first_object_id) continue;
      throw Error(
          {.problem = "the image shows a point that the cloud lacks; it was rendered from another cloud",
           .expected = "point ids up to " + std::to_string(point_count),
           .found = std::to_string(ids[pixel])});
    }
    points.push_back({ids[pixel] - 1, changes.labels[pixel]});
  }
  // Regions are numbered by size, so the largest one of a point comes first.
  std::ranges::sort(points, [](const RegionPoint& a, const RegionPoint& b) {
    return a.id != b.id ? a.id < b.id : a.region < b.region;
  });
  const auto is_same = [](const RegionPoint& a, const RegionPoint& b) { return a.id == b.id; };
  points.erase(std::unique(points.begin(), points.end(), is_same), points.end());
  return points;
}

PointCloud points_of_regions(const PointCloud& cloud, std::span<const RegionPoint> points) {
  PointCloud result;
  result.lattice = cloud.lattice;
  result.crs = cloud.crs;
  result.records = cloud.records;
  result.gps_time_is_standard = cloud.gps_time_is_standard;
  result.project_id = cloud.project_id;
  result.file_source_id = cloud.file_source_id;
  const auto pick = [&](auto& column, const auto& all) {
    if (all.empty()) return;
    column.reserve(points.size());
    for (const RegionPoint& point : points) column.push_back(all[point.id]);
  };
  pick(result.positions, cloud.positions);
  for_each_column(result, cloud, [&](Attribute, auto& column, const auto& all) { pick(column, all); });
  for (const ExtraDimension& all : cloud.extra_dimensions) {
    if (all.name == k_region_name) continue;
    ExtraDimension& column = result.extra_dimensions.emplace_back(description_of(all));
    const auto bytes = static_cast<std::size_t>(all.byte_count);
    column.values.resize(points.size() * bytes);
    for (std::size_t i = 0; i < points.size(); ++i)
      std::memcpy(column.values.data() + i * bytes, all.values.data() + points[i].id * bytes, bytes);
  }
  ExtraDimension& regions = result.extra_dimensions.emplace_back(region_dimension());
  regions.values.reserve(4 * points.size());
  for (const RegionPoint& point : points)
    for (int shift = 0; shift < 32; shift += 8)
      regions.values.push_back(static_cast<std::uint8_t>(point.region >> shift));
  return result;
}

}  // namespace alidade::compare
