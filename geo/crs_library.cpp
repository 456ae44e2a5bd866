// SPDX-License-Identifier: MIT
#include "geo/crs_library.h"

#include <algorithm>
#include <string_view>

#include "cloud/axis_units.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

std::string version_1_of(const GdalReference& reference) {
  return wkt_in_format(reference.get(), "FORMAT=WKT1");
}

bool is_same(const GdalReference& a, const GdalReference& b) {
  const char* const options[] = {"CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS",
                                 "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  return OSRIsSameEx(a.get(), b.get(), options) != 0;
}

/// The code that a part of a system has, such as "DATUM"; empty if it has none.
std::string code_of(const GdalReference& reference, const char* part) {
  const char* const code = OSRGetAuthorityCode(reference.get(), part);
  return code != nullptr ? code : "";
}

/// The name of a projection in version 1 of WKT; empty for systems without one.
std::string projection_of(const GdalReference& reference) {
  const char* const name = OSRGetAttrValue(reference.get(), "PROJECTION", 0);
  return name != nullptr ? name : "";
}

/// Whether an axis counts westwards, as in Krovak's older system (EPSG:5513). (South is a direction of polar
/// systems, too, which not all programs write.)
bool is_mirrored(const GdalReference& reference) {
  for (int axis = 0; axis < 2; ++axis) {
    OGRAxisOrientation direction = OAO_Other;
    OSRGetAxis(reference.get(), nullptr, axis, &direction);
    if (direction == OAO_West) return true;
  }
  return false;
}

/// x and y of a system without what does not affect them in clouds, whose x is always east (or west): the
/// order of axes, and parameters to other datums.
GdalReference plane_of(const GdalReference& reference) {
  GdalReference plane(OSRClone(reference.get()));
  OSRStripVertical(plane.get());
  std::string wkt = version_1_of(plane);
  for (const std::string_view key : {",AXIS[", ",TOWGS84["}) {
    for (std::string_view node = wkt_node(wkt, {key}); !node.empty(); node = wkt_node(wkt, {key}))
      wkt.erase(static_cast<std::size_t>(node.data() - wkt.data()), node.size());
  }
  // Systems that version 1 of WKT does not support stay as they are.
  if (GdalReference bare = reference_of_wkt(wkt)) return bare;
  return plane;
}

CrsAgreement compare_planes(const GdalReference& a, const GdalReference& b) {
  using enum CrsAgreement;
  const GdalReference one = plane_of(a), other = plane_of(b);
  if (is_mirrored(a) != is_mirrored(b)) return different;
  if (is_same(one, other)) return same;
  // Some projections have equal parameters.
  if (projection_of(one) != projection_of(other) || !same_definition(version_1_of(one), version_1_of(other)))
    return different;
  // PROJ distinguishes datums by name, and programs write names of their own.
  const std::string datum = code_of(one, "DATUM"), other_datum = code_of(other, "DATUM");
  if (datum.empty() || other_datum.empty()) return unknown;
  return datum == other_datum ? same : different;
}

GdalReference heights_of(const std::string& wkt) {
  return reference_of_wkt(std::string(wkt_node(wkt, {"VERT_CS[", "VERTCRS[", "VERTICALCRS["})));
}

/// Of heights; that of x and y where they state none.
std::optional<LengthUnit> height_unit_of(const Crs& crs, const std::string& wkt) {
  const AxisUnits stated = stated_units(crs), known = stated_units(crs_of_wkt(wkt));
  if (stated.heights) return stated.heights;
  return known.heights ? known.heights : known.plane;
}

CrsAgreement compare_heights(const Crs& a, const std::string& wkt_a, const Crs& b, const std::string& wkt_b) {
  using enum CrsAgreement;
  const auto unit = height_unit_of(a, wkt_a), other_unit = height_unit_of(b, wkt_b);
  if (unit && other_unit && *unit != *other_unit) return different;
  const GdalReference heights = heights_of(wkt_a), other_heights = heights_of(wkt_b);
  if (!heights || !other_heights || is_same(heights, other_heights)) return same;
  const auto is_known = [](const GdalReference& reference) {
    return !code_of(reference, "VERT_CS").empty() || !code_of(reference, "VERT_DATUM").empty();
  };
  return is_known(heights) && is_known(other_heights) ? different : unknown;
}

}  // namespace

std::string library_wkt(const Crs& crs) {
  const GdalOption heights("GTIFF_REPORT_COMPD_CS", "YES");
  const std::string wkt = wkt_of(crs);
  if (!crs.wkt.empty()) return wkt;
  // GDAL's name for keys that it cannot read.
  if (wkt.empty() || wkt.starts_with("LOCAL_CS[")) return "";
  const std::optional<LengthUnit> stated = stated_units(crs).heights;
  return stated ? with_height_unit(crs_of_wkt(wkt), *stated).wkt : wkt;
}

std::optional<CrsAgreement> compare_systems(const Crs& a, const Crs& b) {
  using enum CrsAgreement;
  const QuietGdal quiet;
  const std::string wkt_a = library_wkt(a), wkt_b = library_wkt(b);
  const GdalReference one = reference_of_wkt(wkt_a), other = reference_of_wkt(wkt_b);
  if (!one || !other) return std::nullopt;
  if (OSRIsSame(one.get(), other.get()) != 0) return same;
  if (OSRIsLocal(one.get()) != 0 || OSRIsLocal(other.get()) != 0) return unknown;
  if (OSRIsGeocentric(one.get()) != 0 || OSRIsGeocentric(other.get()) != 0) return different;
  return std::max(compare_planes(one, other), compare_heights(a, wkt_a, b, wkt_b));
}

}  // namespace alidade::geo
