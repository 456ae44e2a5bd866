// SPDX-License-Identifier: MIT
#include "tools/visibility/cloud_unit.h"

#include <cmath>

#include "geo/map_unit.h"
#include "tools/map_reference.h"

namespace alidade {
namespace {

/// Feet of all countries are one word to people.
std::string name_of(double metres) {
  constexpr double k_foot = 0.3048, k_rounding = 1e-5;
  if (std::fabs(metres - 1.0) < k_rounding) return "m";
  return std::fabs(metres - k_foot) < k_rounding ? "ft" : "";
}

}  // namespace

CloudUnit cloud_unit(const Crs& crs) {
  if (crs.empty()) return {};
  CloudUnit unit;
  load_metres_per_unit()(crs, unit.metres);
  if (!unit.metres) {
    const MapUnit told = map_unit(crs);
    if (told == MapUnit::unknown) return {};
    unit.metres = metres_per_unit(told);
  }
  unit.name = name_of(*unit.metres);
  return unit;
}

}  // namespace alidade
