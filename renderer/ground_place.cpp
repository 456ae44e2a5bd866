// SPDX-License-Identifier: MIT
#include "renderer/ground_place.h"

#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
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

Transformation between(const Reference& from, const Reference& to) {
  return Transformation(OCTNewCoordinateTransformation(from.get(), to.get()));
}

std::optional<glm::dvec2> transformed(const Transformation& transformation, glm::dvec2 place) {
  if (OCTTransform(transformation.get(), 1, &place.x, &place.y, nullptr) == 0) return {};
  if (!std::isfinite(place.x) || !std::isfinite(place.y)) return {};
  return place;
}

}  // namespace

std::optional<GroundPlace> ground_place(const Crs& crs, const glm::dvec2& place) {
  constexpr double k_step = 1e-4;
  const std::string wkt = wkt_of(crs);
  if (wkt.empty()) return {};
  const QuietGdal quiet;
  const Reference map(OSRNewSpatialReference(nullptr)), globe(OSRNewSpatialReference(nullptr));
  char* text = const_cast<char*>(wkt.c_str());
  if (OSRImportFromWkt(map.get(), &text) != OGRERR_NONE) return {};
  if (OSRIsGeocentric(map.get()) != 0 || OSRIsLocal(map.get()) != 0) return {};
  if (OSRImportFromEPSG(globe.get(), 4326) != OGRERR_NONE) return {};
  // Heights do not move a place, and their grids may not be installed.
  OSRStripVertical(map.get());
  for (const Reference* const each : {&map, &globe})
    OSRSetAxisMappingStrategy(each->get(), OAMS_TRADITIONAL_GIS_ORDER);
  const Transformation to_globe = between(map, globe), to_map = between(globe, map);
  if (!to_globe || !to_map) return {};

  const auto there = transformed(to_globe, place);
  if (!there || std::fabs(there->y) > 90.0) return {};
  const auto north = transformed(to_map, {there->x, std::min(there->y + k_step, 90.0)});
  const auto south = transformed(to_map, {there->x, std::max(there->y - k_step, -90.0)});
  if (!north || !south || *north == *south) return {};
  const glm::dvec2 northward = *north - *south;
  return GroundPlace{there->y, there->x,
                     -std::atan2(northward.x, northward.y) * 180.0 / std::numbers::pi + 0.0};
}

}  // namespace alidade
