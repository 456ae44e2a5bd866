// SPDX-License-Identifier: MIT
#include "extensions/photos/photo_file.h"

#include <algorithm>

#include "geo/geopackage.h"

namespace alidade::visibility {
namespace {

using geo::ColumnType;
using geo::VectorValue;

std::int64_t number_of(std::uint64_t number) {
  return static_cast<std::int64_t>(number);
}

double share_of_points(std::uint64_t part, std::uint64_t all) {
  return static_cast<double>(part) / static_cast<double>(all);
}

geo::VectorLayer footprints(const PhotoVisibility& seen, std::span<const camera::NamedCamera> photos) {
  geo::VectorLayer layer{.name = "footprints",
                         .description = "where each photo sees points of the cloud",
                         .shape = geo::LayerShape::polygons,
                         .columns = {{"number", ColumnType::whole_number},
                                     {"photo", ColumnType::text},
                                     {"x", ColumnType::number},
                                     {"y", ColumnType::number},
                                     {"z", ColumnType::number},
                                     {"points", ColumnType::whole_number},
                                     {"share", ColumnType::number},
                                     {"sampling", ColumnType::number},
                                     {"distance", ColumnType::number},
                                     {"overlap", ColumnType::number}},
                         .features = {}};
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const PhotoSummary& photo = seen.photos[i];
    const glm::dvec3& position = photos[i].camera.pose.position;
    const auto if_any = [&](double value) { return photo.points > 0 ? VectorValue(value) : VectorValue(); };
    layer.features.push_back(
        {photo.footprint,
         {number_of(i + 1), photos[i].name, position.x, position.y, position.z, number_of(photo.points),
          share_of_points(photo.points, seen.counts.size()), if_any(photo.median_sampling),
          if_any(photo.median_distance), if_any(photo.largest_overlap)}});
  }
  return layer;
}

geo::VectorLayer overlap_lines(const PhotoVisibility& seen, std::span<const camera::NamedCamera> photos) {
  geo::VectorLayer layer{.name = "overlaps",
                         .description = "pairs of photos that see the same points",
                         .shape = geo::LayerShape::lines,
                         .columns = {{"first", ColumnType::whole_number},
                                     {"second", ColumnType::whole_number},
                                     {"first_photo", ColumnType::text},
                                     {"second_photo", ColumnType::text},
                                     {"points", ColumnType::whole_number},
                                     {"share", ColumnType::number}},
                         .features = {}};
  for (const PhotoOverlap& pair : seen.overlaps) {
    const camera::NamedCamera &first = photos[pair.first], &second = photos[pair.second];
    const std::uint64_t fewer = std::min(seen.photos[pair.first].points, seen.photos[pair.second].points);
    layer.features.push_back({std::vector{first.camera.pose.position, second.camera.pose.position},
                              {number_of(pair.first + 1), number_of(pair.second + 1), first.name, second.name,
                               number_of(pair.points), share_of_points(pair.points, fewer)}});
  }
  return layer;
}

}  // namespace

void write_photos(const PhotoVisibility& seen, std::span<const camera::NamedCamera> photos, const Crs& crs,
                  const std::filesystem::path& file, bool overwrite) {
  geo::write_geopackage(file, {footprints(seen, photos), overlap_lines(seen, photos)}, crs, overwrite);
}

}  // namespace alidade::visibility
