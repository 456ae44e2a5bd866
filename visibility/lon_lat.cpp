// SPDX-License-Identifier: MIT
#include "visibility/lon_lat.h"

#include <ogr_srs_api.h>

#include <cmath>
#include <memory>
#include <string>

#include "renderer/gdal_handles.h"
#include "renderer/image_geotiff.h"

namespace alidade {
namespace {

struct Release {
  void operator()(void* reference) const { OSRRelease(reference); }
};
using Reference = std::unique_ptr<void, Release>;

struct Destroy {
  void operator()(void* transformation) const { OCTDestroyCoordinateTransformation(transformation); }
};
using Transformation = std::unique_ptr<void, Destroy>;

/// The system of the map alone, with x before y; empty if GDAL does not know it.
Reference map_of(const Crs& crs) {
  const std::string wkt = wkt_of(crs);
  Reference map(OSRNewSpatialReference(nullptr));
  char* text = const_cast<char*>(wkt.c_str());
  if (wkt.empty() || OSRImportFromWkt(map.get(), &text) != OGRERR_NONE) return nullptr;
  if (OSRIsGeocentric(map.get()) != 0 || OSRIsLocal(map.get()) != 0) return nullptr;
  // Heights do not move a place, and their grids may not be installed.
  OSRStripVertical(map.get());
  OSRSetAxisMappingStrategy(map.get(), OAMS_TRADITIONAL_GIS_ORDER);
  return map;
}

double rounded(double degrees) {
  return std::round(degrees * 1e9) / 1e9;
}

}  // namespace

std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> places) {
  const QuietGdal quiet;
  const Reference map = map_of(crs);
  if (!map) return std::nullopt;
  const Reference globe(OSRNewSpatialReference(nullptr));
  if (OSRImportFromEPSG(globe.get(), 4326) != OGRERR_NONE) return std::nullopt;
  OSRSetAxisMappingStrategy(globe.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const Transformation transformation(OCTNewCoordinateTransformation(map.get(), globe.get()));
  if (!transformation) return std::nullopt;
  std::vector<glm::dvec3> answers(places.begin(), places.end());
  for (glm::dvec3& place : answers) {
    if (OCTTransform(transformation.get(), 1, &place.x, &place.y, nullptr) == 0) return std::nullopt;
    if (!std::isfinite(place.x) || !(std::fabs(place.y) <= 90.0)) return std::nullopt;
    place.x = rounded(place.x);
    place.y = rounded(place.y);
  }
  return answers;
}

std::optional<double> metres_per_unit(const Crs& crs) {
  if (crs.empty()) return 1.0;
  const QuietGdal quiet;
  const Reference map = map_of(crs);
  if (!map || OSRIsProjected(map.get()) == 0) return std::nullopt;
  const double metres = OSRGetLinearUnits(map.get(), nullptr);
  return metres > 0.0 && std::isfinite(metres) ? std::optional(metres) : std::nullopt;
}

}  // namespace alidade
