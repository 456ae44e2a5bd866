// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cloud/crs.h"

namespace alidade {

/// A unit of length, such as "US survey foot".
struct LengthUnit {
  std::string name;
  double metres = 1.0;

  /// Whether both are one length, whatever their names. The feet of surveys are longer by two millionths.
  bool operator==(const LengthUnit& other) const;
};

inline const LengthUnit k_metre{"metre", 1.0}, k_foot{"foot", 0.3048},
    k_survey_foot{"US survey foot", 1200.0 / 3937.0};

/// "m", "ft" and "us-ft"; of others the name.
std::string short_name(const LengthUnit& unit);

/// The units of a system's axes.
struct AxisUnits {
  std::optional<LengthUnit> plane;    ///< of x and y; empty: angles, or unknown
  std::optional<LengthUnit> heights;  ///< of z, where the system states it; empty: unknown, or not stated
  /// Whether the system says something about heights: a vertical part, or a GeoTIFF key. Without it they are taken to
  /// be in the unit of x and y, over angles in metres.
  bool states_heights = false;

  std::optional<LengthUnit> of_z() const { return states_heights ? heights : plane; }
};

/// What WKT and GeoTIFF keys themselves give.
AxisUnits stated_units(const Crs& crs);

/// The same, and of GeoTIFF keys that are codes without units what the library of reference systems knows (CrsLibrary).
AxisUnits axis_units(const Crs& crs);
/// The same, with the WKT that a library makes of GeoTIFF keys; empty: it does not understand them.
AxisUnits axis_units(const Crs& crs, const std::string& whole_wkt);

/// The unit of a file's heights: that of its system, whose units are `units`, else `stated`, by the user
/// (--vertical-unit). Empty if neither states it. Errors: the system has heights in an unknown unit, or `stated`
/// contradicts it.
std::optional<LengthUnit> height_unit_of_file(const Crs& crs, const AxisUnits& units,
                                              const std::optional<LengthUnit>& stated,
                                              const std::filesystem::path& file);

/// How the heights of a file get into the unit of its x and y.
struct HeightChange {
  double factor = 1.0;  ///< multiplies z
  Crs crs;              ///< afterwards
  std::string note;     ///< what people are to be told; empty: nothing changes
};

/// The change that makes one unit of all axes; none over angles, for geocentric systems, and without a system.
/// The new system keeps its datums, and its vertical part has no code any more. Errors: those of height_unit_of_file();
/// the unit of x and y is unknown beside heights that are not metres.
HeightChange heights_in_plane_unit(const Crs& crs, const std::optional<LengthUnit>& stated,
                                   const std::filesystem::path& file);

/// A system with its heights in this unit; it stays what it is if they are, or if it states none. GeoTIFF keys become
/// WKT, by the library (CrsLibrary); without one, those of heights are left out.
Crs with_height_unit(const Crs& crs, const LengthUnit& unit);

}  // namespace alidade
