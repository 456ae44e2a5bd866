// SPDX-License-Identifier: MIT
#include "geo/map_unit.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <string_view>

#include "base/words.h"

namespace alidade::geo {
namespace {

/// "metre", "US survey foot", ... -> "m", "ft"; empty if it is neither, such as degree or unity.
std::optional<std::string> length_unit(const std::string& unit_name) {
  const std::string lower = lower_case(unit_name);
  if (lower == "m" || lower.starts_with("metre") || lower.starts_with("meter")) return "m";
  const bool feet = lower.find("foot") != std::string::npos || lower.find("feet") != std::string::npos ||
                    lower == "ft" || lower == "ftus";
  if (feet) return "ft";
  return std::nullopt;
}

/// The last unit of length that a piece of WKT names: a projected system names its own behind those of the
/// geographic one inside it.
std::optional<std::string> last_unit(const std::string& wkt) {
  constexpr std::string_view k_key = "UNIT[\"";
  std::optional<std::string> unit;
  for (std::size_t at = wkt.find(k_key); at != std::string::npos; at = wkt.find(k_key, at + 1)) {
    const std::size_t begin = at + k_key.size(), end = wkt.find('"', begin);
    if (end == std::string::npos) break;
    if (const auto length = length_unit(wkt.substr(begin, end - begin))) unit = length;
  }
  return unit;
}

std::string unit_of_wkt(const std::string& wkt) {
  for (const std::string_view vertical : {"VERT_CS[", "VERTCRS[", "VERTICALCRS["}) {
    const std::size_t at = wkt.find(vertical);
    if (at != std::string::npos) return last_unit(wkt.substr(at)).value_or("");
  }
  if (const auto unit = last_unit(wkt)) return *unit;
  const bool geographic = wkt.starts_with("GEOGCS[") || wkt.starts_with("GEOGCRS[");
  return geographic ? "m" : "";
}

/// EPSG code of the unit that GeoTIFF keys give in position.
std::optional<int> unit_key(const Crs& crs, std::uint16_t key) {
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    if (crs.geotiff_keys[i] == key && crs.geotiff_keys[i + 1] == 0) return crs.geotiff_keys[i + 3];
  }
  return std::nullopt;
}

std::string unit_of_keys(const Crs& crs) {
  constexpr std::uint16_t k_vertical_units = 4099, k_projected_units = 3076;
  constexpr int k_metre = 9001, k_foot = 9002, k_survey_foot = 9003;
  std::optional<int> unit = unit_key(crs, k_vertical_units);
  if (!unit) unit = unit_key(crs, k_projected_units);
  if (unit == k_metre) return "m";
  return unit == k_foot || unit == k_survey_foot ? "ft" : "";
}

bool names_one_of(const std::string& wkt, std::initializer_list<const char*> keys) {
  return std::ranges::any_of(keys, [&](const char* key) { return wkt.find(key) != std::string::npos; });
}

bool is_in_degrees(const Crs& crs) {
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

/// The part of the system for x and y alone: heights may have another unit.
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

std::string height_unit(const Crs& crs) {
  if (!crs.wkt.empty()) return unit_of_wkt(crs.wkt);
  return crs.geotiff_keys.empty() ? "m" : unit_of_keys(crs);
}

MapUnit map_unit(const Crs& crs) {
  if (crs.empty()) return MapUnit::unknown;
  if (is_in_degrees(crs)) return MapUnit::degree;
  const std::string unit = height_unit(plane_part(crs));
  if (unit == "m") return MapUnit::metre;
  return unit == "ft" ? MapUnit::foot : MapUnit::unknown;
}

const char* unit_name(MapUnit unit) {
  constexpr const char* k_names[] = {"unknown", "m", "ft", "deg"};
  return k_names[static_cast<std::size_t>(unit)];
}

double metres_per_unit(MapUnit unit) {
  assert(unit != MapUnit::degree);
  constexpr double k_foot = 0.3048;
  return unit == MapUnit::foot ? k_foot : 1.0;
}

}  // namespace alidade::geo
