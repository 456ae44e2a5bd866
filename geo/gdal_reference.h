// SPDX-License-Identifier: MIT
#pragma once

#include <ogr_srs_api.h>

#include <memory>

#include "cloud/crs.h"
#include "geo/gdal_handles.h"

// Reference systems as GDAL has them, given back when they are no longer used.

namespace alidade {

struct ReleaseGdalReference {
  void operator()(void* reference) const { OSRRelease(reference); }
};
using GdalReference = std::unique_ptr<void, ReleaseGdalReference>;

struct DestroyGdalTransformation {
  void operator()(void* transformation) const { OCTDestroyCoordinateTransformation(transformation); }
};
using GdalTransformation = std::unique_ptr<void, DestroyGdalTransformation>;

/// Leaves x and y of a system, x before y whatever its axes. Heights do not move a place, and their grids may
/// not be installed.
void make_plane(const GdalReference& reference);

/// The plane part of a cloud's system; null if GDAL does not know it or it lies nowhere on Earth.
GdalReference plane_reference(const Crs& crs);

/// Longitude before latitude, WGS 84; null if GDAL's tables are not installed.
GdalReference globe_reference();

/// Null if there is no way from one to the other.
GdalTransformation transformation_between(const GdalReference& from, const GdalReference& to);

}  // namespace alidade
