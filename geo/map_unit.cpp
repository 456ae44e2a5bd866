// SPDX-License-Identifier: MIT
#include "geo/map_unit.h"

#include <cassert>

#include "cloud/axis_units.h"

namespace alidade::geo {
namespace {

/// "m", or "ft" for the foot and the US survey foot; empty for others.
std::string foot_or_metre(const LengthUnit& unit) {
  if (unit == k_metre) return "m";
  return unit == k_foot || unit == k_survey_foot ? "ft" : "";
}

}  // namespace

std::string height_unit(const Crs& crs) {
  if (crs.empty()) return "m";
  const AxisUnits units = axis_units(crs);
  if (const auto unit = units.of_z()) return foot_or_metre(*unit);
  return !units.states_heights && is_geographic(crs) ? "m" : "";
}

MapUnit map_unit(const Crs& crs) {
  if (is_geographic(crs)) return MapUnit::degree;
  const std::optional<LengthUnit> unit = axis_units(crs).plane;
  const std::string name = unit ? foot_or_metre(*unit) : "";
  return name == "m" ? MapUnit::metre : name == "ft" ? MapUnit::foot : MapUnit::unknown;
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
