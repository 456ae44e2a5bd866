// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "cloud/axis_units.h"
#include "cloud/crs.h"
#include "cloud/input_view.h"

namespace alidade::geo {

/// What the user says about the reference system of clouds; both as anything GDAL understands (EPSG:25832,
/// WKT, PROJ), x east and y north whatever the axes of the system.
struct ReferenceRequest {
  std::string stated{};  ///< that of the file, above what it says itself; empty: what it says
  std::string wanted{};  ///< that the points are to be in; empty: the same
  std::optional<LengthUnit> height_unit{};  ///< of a file that states none; empty: that of its x and y
  bool has_one_unit = false;  ///< heights in the unit of x and y, also where `wanted` has them in another
};

/// How a file's positions get into the wanted system, through PROJ. Heights follow where both systems have
/// heights (EPSG:25832+7837, EPSG:4979), or the file's are geocentric; otherwise they stay on their datum, a compound
/// system keeps its vertical part, and their unit becomes that of the wanted system's heights: where it has none that
/// of its x and y, over degrees metres. Warns where `stated` differs from what the file says. Errors: GDAL does not
/// understand a system; the file's is unknown or local; its points cannot lie in it (implausible_crs()); the unit of
/// its heights is unknown, or `height_unit` contradicts it; there is no way from one to the other. Cost of moving:
/// some us per position, shared by the threads of the task arena (oneTBB).
ReferenceChange change_reference(const ReferenceRequest& request, const std::filesystem::path& file,
                                 const FileFacts& facts);

/// The zone of UTM on WGS 84 in which a position of a system lies, or UPS near a pole: "EPSG:32632". The
/// exceptions in Norway and Svalbard are not made. Empty for a projected system, whose unit is a length
/// anyway. Errors: as change_reference(); the position has no image on Earth.
std::string metric_system(const Crs& crs, const glm::dvec3& position, const std::filesystem::path& file);

/// The system in which GDAL understands a text, as WKT. Errors: it does not.
Crs crs_of_text(const std::string& text);

/// A system as PROJJSON, in one line; empty if GDAL does not understand it. That is no error, since files may
/// say anything.
std::string projjson_of(const Crs& crs);

/// "GDAL 3.6.2, PROJ 9.1.1": what reads and writes maps, and transforms between systems.
std::string library_versions();

}  // namespace alidade::geo
