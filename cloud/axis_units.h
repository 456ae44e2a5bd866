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

  /// Whether both are of one length, with any names. US survey feet are longer than feet by two millionths.
  bool operator==(const LengthUnit& other) const;
};

inline const LengthUnit k_metre{"metre", 1.0}, k_foot{"foot", 0.3048},
    k_survey_foot{"US survey foot", 1200.0 / 3937.0};

/// "m", "ft" or "us-ft"; for other units the name.
std::string short_name(const LengthUnit& unit);

/// The units of a system's axes.
struct AxisUnits {
  std::optional<LengthUnit> plane;    ///< of x and y; empty: angles, or unknown
  std::optional<LengthUnit> heights;  ///< of z, where the system states it; empty: unknown, or not stated
  /// Whether the system has a vertical part or a GeoTIFF key for heights. Without it, heights are assumed to
  /// be in the unit of x and y, or in metres if these are angles.
  bool states_heights = false;

  std::optional<LengthUnit> of_z() const { return states_heights ? heights : plane; }
};

/// The units that WKT and GeoTIFF keys state themselves.
AxisUnits stated_units(const Crs& crs);

/// stated_units(). For GeoTIFF keys that contain codes instead of units, the units are those that the
/// CrsLibrary has for the codes.
AxisUnits axis_units(const Crs& crs);
/// axis_units() with the WKT that a library made of GeoTIFF keys; empty if it does not support them.
AxisUnits axis_units(const Crs& crs, const std::string& whole_wkt);

/// The unit of z: that of the system's heights; if it states none, that of x and y, or metres over angles.
/// Empty: unknown.
std::optional<LengthUnit> height_unit(const Crs& crs);

// Units for legends: "m", "ft" for the foot and the US survey foot, or empty for others and unknown ones.

/// The unit of x and y; "deg" for angles.
std::string plane_unit_label(const Crs& crs);
/// height_unit(); "m" for a cloud without any system.
std::string height_unit_label(const Crs& crs);

/// The unit of a file's heights: that of its system, whose units are `units`, or else `stated`, the user's
/// (--vertical-unit). Empty if neither is known. Errors: the system has heights in an unknown unit, or
/// `stated` contradicts it.
std::optional<LengthUnit> height_unit_of_file(const Crs& crs, const AxisUnits& units,
                                              const std::optional<LengthUnit>& stated,
                                              const std::filesystem::path& file);

/// How the heights of a file are converted to the unit of its x and y.
struct HeightChange {
  double factor = 1.0;  ///< multiplies z
  Crs crs;              ///< of the converted file
  std::string note;     ///< a clause on it for the user; empty: nothing changes
};

/// The change that gives all axes one unit. Nothing changes if x and y are angles, in geocentric systems, and
/// without a system. The new system keeps its datums, but its vertical part loses its code. Errors: those of
/// height_unit_of_file(); the unit of x and y is unknown and heights are not metres.
HeightChange heights_in_plane_unit(const Crs& crs, const std::optional<LengthUnit>& stated,
                                   const std::filesystem::path& file);

/// The system with its heights in this unit. A system without heights stays unchanged, as does one whose
/// heights have this unit. GeoTIFF keys become WKT by the CrsLibrary; without a library, the keys of heights
/// are left out.
Crs with_height_unit(const Crs& crs, const LengthUnit& unit);

}  // namespace alidade
