// SPDX-License-Identifier: MIT
#include "cloud/crs_plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

namespace alidade {
namespace {

constexpr std::uint16_t k_model_type = 1024, k_geographic_type = 2048, k_projected_type = 3072;
constexpr std::uint16_t k_geographic_model = 2, k_geocentric_model = 3;

/// Value of a GeoTIFF key that is stored in place.
std::optional<std::uint16_t> value_of_key(const Crs& crs, std::uint16_t key) {
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4)
    if (crs.geotiff_keys[i] == key && crs.geotiff_keys[i + 1] == 0) return crs.geotiff_keys[i + 3];
  return std::nullopt;
}

bool has_any(const std::string& text, const auto& words) {
  return std::ranges::any_of(words,
                             [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

/// Whether WKT of version 2 is that of a geodetic system, as which it counts geographic and geocentric ones,
/// with such coordinates.
bool is_geodetic(const std::string& wkt, std::string_view coordinates) {
  return (wkt.starts_with("GEODCRS[") || wkt.starts_with("GEODETICCRS[")) &&
         wkt.find(coordinates) != std::string::npos;
}

}  // namespace

bool is_geographic(const Crs& crs) {
  // A projected system names the geographic one that it stands on, so the projected one decides.
  constexpr std::array<std::string_view, 3> k_other = {"PROJCS[", "PROJCRS[", "PROJECTEDCRS["};
  constexpr std::array<std::string_view, 3> k_geographic = {"GEOGCS[", "GEOGCRS[", "GEOGRAPHICCRS["};
  if (!crs.wkt.empty()) {
    return !has_any(crs.wkt, k_other) &&
           (has_any(crs.wkt, k_geographic) || is_geodetic(crs.wkt, "CS[ellipsoidal"));
  }
  if (const auto model = value_of_key(crs, k_model_type)) return *model == k_geographic_model;
  return value_of_key(crs, k_geographic_type) && !value_of_key(crs, k_projected_type);
}

bool is_geocentric(const Crs& crs) {
  if (!crs.wkt.empty()) {
    return has_any(crs.wkt, std::array<std::string_view, 1>{"GEOCCS["}) ||
           is_geodetic(crs.wkt, "CS[Cartesian,3]");
  }
  return value_of_key(crs, k_model_type) == k_geocentric_model;
}

std::optional<std::string> implausible_crs(const Crs& crs, const Bounds& bounds) {
  constexpr double k_widest_angle = 400.0, k_least_radius = 6.3e6, k_largest_radius = 6.5e6;
  if (bounds.empty()) return std::nullopt;
  if (is_geocentric(crs)) {
    const double radius = glm::length(bounds.center());
    if (radius >= k_least_radius && radius <= k_largest_radius) return std::nullopt;
    return fmt::format(
        "the coordinate reference system is geocentric, but the points lie {:.0f} from its origin, which is "
        "not "
        "where the ground is: they lie in another system, probably a projected one",
        radius);
  }
  if (!is_geographic(crs)) return std::nullopt;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double coordinate : {bounds.min[axis], bounds.max[axis]}) {
      if (std::fabs(coordinate) <= k_widest_angle) continue;
      return fmt::format(
          "the coordinate reference system says longitude and latitude, but {} {} is no angle: the points "
          "lie in "
          "another system, probably a projected one",
          axis == 0 ? "x" : "y", coordinate);
    }
  }
  return std::nullopt;
}

}  // namespace alidade
