// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "cloud/point_cloud.h"
#include "geo/raster.h"

namespace alidade::test {

using namespace geo;

/// A grid in GRASS's ASCII form; "*" is NaN. Requires square cells.
Raster<double> read_ascii_grid(const std::filesystem::path& file);

/// Bilinear between the middles of cells, as on the outermost ones beyond them.
double interpolated(const Raster<double>& grid, const glm::dvec2& position);

/// Points of class 2 all `spacing` over the grid, on its interpolated surface; the first ones half a spacing
/// from the edges.
PointCloud cloud_on(const Raster<double>& grid, double spacing);

}  // namespace alidade::test
