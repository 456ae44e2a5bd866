// SPDX-License-Identifier: MIT
#include "geo/map_unit.h"

#include <cassert>
#include <string>

#include "cloud/crs.h"
#include "geo/height_unit.h"

namespace alidade {
namespace {

bool names_one_of(const std::string& wkt, std::initializer_list<const char*> keys) {
  for (const char* const key : keys) {
    if (wkt.find(key) != std::string::npos) return true;
  }
  return false;
}

bool is_geographic(const Crs& crs) {
  if (!crs.wkt.empty()) {
    return names_one_of(crs.wkt, {"GEOGCS[", "GEOGCRS["}) && !names_one_of(crs.wkt, {"PROJCS[", "PROJCRS["});
  }
  // GeoTIFF 1.1, 7.1: kind of model, 2 = geographic.
  constexpr std::uint16_t k_model_type = 1024, k_geographic = 2;
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    if (crs.geotiff_keys[i] == k_model_type) return crs.geotiff_keys[i + 3] == k_geographic;
  }
  return false;
}

/// What tells of x and y alone: heights may be counted in another unit.
Crs plane_part(const Crs& crs) {
  constexpr std::uint16_t k_vertical_units = 4099;
  Crs plane;
  plane.wkt = wkt_node(crs.wkt, {"PROJCS[", "PROJCRS[", "PROJECTEDCRS["});
  if (plane.wkt.empty()) plane.wkt = crs.wkt;
  plane.geotiff_keys = crs.geotiff_keys;
  for (std::size_t i = 4; i + 3 < plane.geotiff_keys.size(); i += 4) {
    if (plane.geotiff_keys[i] == k_vertical_units) plane.geotiff_keys[i] = 0;
  }
  return plane;
}

}  // namespace

MapUnit map_unit(const Crs& crs) {
  if (crs.empty()) return MapUnit::unknown;
  if (is_geographic(crs)) return MapUnit::degree;
  const std::string unit = height_unit(plane_part(crs));
  if (unit == "m") return MapUnit::metre;
  return unit == "ft" ? MapUnit::foot : MapUnit::unknown;
}

double metres_per_unit(MapUnit unit) {
  assert(unit != MapUnit::degree);
  constexpr double k_foot = 0.3048;
  return unit == MapUnit::foot ? k_foot : 1.0;
}

}  // namespace alidade
