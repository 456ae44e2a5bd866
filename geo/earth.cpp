// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geo/earth.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

double to_billionths(double degrees) {
  return std::round(degrees * 1e9) / 1e9;
}

}  // namespace

std::optional<GroundPosition> ground_position(const Crs& crs, const glm::dvec2& position) {
  constexpr double k_step = 1e-4;
  const QuietGdal quiet;
  const GdalReference map = plane_reference(crs), globe = globe_reference();
  if (!map || !globe) return {};
  const GdalTransformation to_globe = transformation_between(map, globe),
                           to_map = transformation_between(globe, map);
  if (!to_globe || !to_map) return {};

  const auto there = transformed(position, to_globe);
  if (!there || std::fabs(there->y) > 90.0) return {};
  const auto north = transformed({there->x, std::min(there->y + k_step, 90.0)}, to_map);
  const auto south = transformed({there->x, std::max(there->y - k_step, -90.0)}, to_map);
  if (!north || !south || *north == *south) return {};
  const glm::dvec2 northward = *north - *south;
  return GroundPosition{there->y, there->x,
                        -std::atan2(northward.x, northward.y) * 180.0 / std::numbers::pi + 0.0};
}

std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> positions) {
  const QuietGdal quiet;
  const GdalReference map = plane_reference(crs), globe = globe_reference();
  if (!map || !globe) return std::nullopt;
  const GdalTransformation transformation = transformation_between(map, globe);
  if (!transformation) return std::nullopt;
  std::vector<glm::dvec3> answers(positions.begin(), positions.end());
  for (glm::dvec3& position : answers) {
    const auto there = transformed({position.x, position.y}, transformation);
    if (!there || std::fabs(there->y) > 90.0) return std::nullopt;
    position = {to_billionths(there->x), to_billionths(there->y), position.z};
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

}  // namespace alidade::geo
