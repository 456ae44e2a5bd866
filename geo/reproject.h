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

/// The user's reference systems for clouds; both as any text that GDAL understands (EPSG:25832, WKT, PROJ), x
/// east and y north whatever the axes of the system.
struct ReferenceRequest {
  std::string stated{};                     ///< of the file, overriding its own; empty: its own
  std::string wanted{};                     ///< of the points after reading; empty: that of the file
  std::optional<LengthUnit> height_unit{};  ///< of a file that states none; empty: that of its x and y
  bool has_one_unit = false;  ///< heights in the unit of x and y, also where `wanted` has them in another
};

/// The change of a file's positions to the wanted system, through PROJ. Heights follow where both systems
/// have heights (EPSG:25832+7837, EPSG:4979), or the file's are geocentric; otherwise they stay on their
/// datum, a compound system keeps its vertical part, and their unit becomes that of the wanted system's
/// heights: where it has none that of its x and y, over degrees metres. Warns where `stated` differs from the
/// file's own. Errors: GDAL does not understand a system; the file's is unknown or local; its points cannot
/// lie in it (implausible_crs()); the unit of its heights is unknown, or `height_unit` contradicts it; there
/// is no transformation between the two. Cost of moving: some us per position, shared by the threads of the
/// task arena (oneTBB).
ReferenceChange change_reference(const ReferenceRequest& request, const std::filesystem::path& file,
                                 const FileFacts& facts);

/// The zone of UTM on WGS 84 in which a position of a system lies, or UPS near a pole: "EPSG:32632". The
/// exceptions in Norway and Svalbard are not made. Empty for a projected system, whose unit is a length
/// anyway. Errors: as change_reference(); the position has no image on Earth.
std::string metric_system(const Crs& crs, const glm::dvec3& position, const std::filesystem::path& file);

/// The system that a text denotes, as WKT. Errors: GDAL does not understand it.
Crs crs_of_text(const std::string& text);

/// A system as PROJJSON, in one line; empty if GDAL does not understand it, which is no error: files may
/// contain any text.
std::string projjson_of(const Crs& crs);

}  // namespace alidade::geo
