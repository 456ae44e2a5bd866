// SPDX-License-Identifier: MIT
#include "geo/lon_lat.h"

#include <cmath>

#include "geo/gdal_reference.h"

namespace alidade {
namespace {

double rounded(double degrees) {
  return std::round(degrees * 1e9) / 1e9;
}

}  // namespace

std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> places) {
  const QuietGdal quiet;
  const GdalReference map = plane_reference(crs), globe = globe_reference();
  if (!map || !globe) return std::nullopt;
  const GdalTransformation transformation = transformation_between(map, globe);
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
  const GdalReference map = plane_reference(crs);
  if (!map || OSRIsProjected(map.get()) == 0) return std::nullopt;
  const double metres = OSRGetLinearUnits(map.get(), nullptr);
  return metres > 0.0 && std::isfinite(metres) ? std::optional(metres) : std::nullopt;
}

}  // namespace alidade
