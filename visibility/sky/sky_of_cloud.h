// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "geo/raster.h"
#include "visibility/raster/ground.h"
#include "visibility/sky/sky_view.h"
#include "visibility/sky/sun_hours.h"

// Sky and sun of all points of a cloud, and of the ground below it.
//
//   const Occluders occluders(octree, {});
//   const std::vector<float> views = point_sky_views(occluders, columns.normals, {});

namespace alidade::visibility {

/// Progress and checkpoint of long work.
struct LongWork {
  Progress progress{};              ///< in points or cells
  PartCheckpoint* parts = nullptr;  ///< where finished blocks of them are kept; null: nowhere
};

/// Sky-view factor of every point, by point id. `normals` by point id, each pointing out of its surface (of
/// any length; zero: unknown); empty: the open side is found as in sky_views(). Memory: 4 B per point and
/// some 20 MB. Errors: as sky_views; normals not one per point; those of `work.parts`, here and below.
std::vector<float> point_sky_views(const Occluders& occluders, std::span<const glm::vec3> normals,
                                   const SkyViewOptions& options, const LongWork& work = {});

/// Radiation of every point, by point id: `light.periods` of the first, then those of the next. The open side
/// of points without a normal is found with find_open_sides(), of 64 directions. With a bounce each side of a
/// point is computed once, for receiving and reflecting. Memory: 32 B per point and period, with a bounce
/// 48 B, and some 20 MB. Errors: as sun_hours; normals not one per point.
std::vector<Radiation> point_sun_hours(const Occluders& occluders, std::span<const glm::vec3> normals,
                                       const SunLight& light, const SunHoursOptions& options,
                                       const LongWork& work = {});

/// Sky-view factor in the middle of every cell, `height` above the ground as in a viewshed
/// (visibility/raster/map_targets.h). The receiver is the horizontal, or the slope of the ground across the
/// cell (SkyReceiver::surface), which receives no light from behind; NaN without ground. Memory: 4 B per
/// cell and some 30 MB; check_map_memory() of one band. Errors: as sky_views; height negative or not
/// finite; not enough memory.
geo::Raster<float> ground_sky_views(const Occluders& occluders, const Ground& ground,
                                    const geo::RasterGrid& grid, double height, const SkyViewOptions& options,
                                    const LongWork& work = {});

/// Radiation of every cell, with receivers as in ground_sky_views(), a raster for each period; hours are NaN
/// without ground. With a bounce one point represents all in cubes as wide as the cells (bounced_light.h).
/// Memory: 16 B per cell and period; check_map_memory() of 5 bands for each.
std::vector<geo::Raster<Radiation>> ground_sun_hours(const Occluders& occluders, const Ground& ground,
                                                     const geo::RasterGrid& grid, double height,
                                                     const SunLight& light, const SunHoursOptions& options,
                                                     const LongWork& work = {});

}  // namespace alidade::visibility
