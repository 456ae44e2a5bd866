// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "cloud/crs.h"
#include "extensions/photos/photo_visibility.h"

namespace alidade::visibility {

/// Writes a GeoPackage with two layers in the reference system of the cloud:
/// - `footprints`: a multi-polygon per photo, PhotoSummary::footprint; a photo that sees no point has none.
///   Columns: number (from 1), photo, x, y, z of the camera, points, share (of the cloud's points), sampling
///   and distance (medians; null without points), overlap (PhotoSummary::largest_overlap).
/// - `overlaps`: a line between the cameras of each pair with points in common. Columns: first, second
///   (numbers), first_photo, second_photo, points, share (of the points of the photo that sees fewer).
/// Requires footprints. Errors: those of geo::write_geopackage().
void write_photos(const PhotoVisibility& seen, std::span<const camera::NamedCamera> photos, const Crs& crs,
                  const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
