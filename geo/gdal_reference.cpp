// SPDX-License-Identifier: MIT
#include "geo/gdal_reference.h"

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "base/error.h"
#include "geo/geotiff.h"

namespace alidade {

void make_plane(const GdalReference& reference) {
  OSRStripVertical(reference.get());
  OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
}

GdalReference plane_reference(const Crs& crs) {
  const std::string wkt = wkt_of(crs);
  GdalReference reference(OSRNewSpatialReference(nullptr));
  char* text = const_cast<char*>(wkt.c_str());
  if (wkt.empty() || OSRImportFromWkt(reference.get(), &text) != OGRERR_NONE) return nullptr;
  if (OSRIsGeocentric(reference.get()) != 0 || OSRIsLocal(reference.get()) != 0) return nullptr;
  make_plane(reference);
  return reference;
}

GdalReference globe_reference() {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  if (OSRImportFromEPSG(reference.get(), 4326) != OGRERR_NONE) return nullptr;
  make_plane(reference);
  return reference;
}

GdalTransformation transformation_between(const GdalReference& from, const GdalReference& to) {
  return GdalTransformation(OCTNewCoordinateTransformation(from.get(), to.get()));
}

namespace {

/// What the user wrote, or the WKT of a file; null for text that says nothing. Errors: GDAL does not
/// understand it.
GdalReference read_reference(const std::string& text, bool is_wkt, const std::string& whose,
                             const std::string& way_out) {
  if (text.empty()) return nullptr;
  GdalReference reference(OSRNewSpatialReference(nullptr));
  char* wkt = const_cast<char*>(text.c_str());
  const OGRErr error =
      is_wkt ? OSRImportFromWkt(reference.get(), &wkt) : OSRSetFromUserInput(reference.get(), text.c_str());
  if (error != OGRERR_NONE) {
    throw Error({.problem = "the reference system of " + whose + " is not understood",
                 .expected = way_out,
                 .found = text});
  }
  return reference;
}

/// The plane part of a reference system, x east and y north; null for one that does not say where on Earth
/// things are.
GdalReference plane_part(GdalReference reference) {
  if (!reference || OSRIsLocal(reference.get()) != 0) return nullptr;
  // So GeoPackage calls what it does not know.
  const char* const name = OSRGetName(reference.get());
  if (name != nullptr && std::string_view(name).starts_with("Undefined")) return nullptr;
  make_plane(reference);
  return reference;
}

}  // namespace

GdalTransformation transformation_to_cloud(const std::string& own, const ObserverReference& reference,
                                           const std::string& source) {
  if (reference.given == "cloud") return nullptr;
  const QuietGdal quiet;
  const bool is_wkt = reference.given.empty();
  const std::string& option = reference.option;
  const std::string& whose = reference.whose;
  const std::string way_out = fmt::format("{0} SYSTEM, or {0} cloud if they are in the cloud's own", option);
  const GdalReference from =
      plane_part(read_reference(is_wkt ? own : reference.given, is_wkt, "the " + whose, way_out));
  const GdalReference to = plane_part(read_reference(wkt_of(reference.cloud), true, "the cloud", way_out));
  if (!from && !to) return nullptr;
  if (!from || !to) {
    const std::string cloud = "cloud";
    throw Error({.file = source,
                 .problem = fmt::format("the reference system of the {} is not known, but that of the {} is",
                                        to ? whose : cloud, to ? cloud : whose),
                 .expected = to ? way_out : option + " cloud if they are in the cloud's own"});
  }
  if (OSRIsSame(from.get(), to.get()) != 0) return nullptr;
  GdalTransformation transformation = transformation_between(from, to);
  if (!transformation) {
    throw Error(
        {.problem = fmt::format("there is no way from the {}' reference system to the cloud's", whose),
         .found = CPLGetLastErrorMsg()});
  }
  return transformation;
}

glm::dvec2 transformed(const glm::dvec2& place, const GdalTransformation& transformation,
                       const std::string& source) {
  const QuietGdal quiet;
  glm::dvec2 image = place;
  if (OCTTransform(transformation.get(), 1, &image.x, &image.y, nullptr) == 0 || !std::isfinite(image.x) ||
      !std::isfinite(image.y)) {
    throw Error({.file = source,
                 .problem = "has no place in the cloud's reference system",
                 .found = fmt::format("{}, {}", place.x, place.y)});
  }
  return image;
}

}  // namespace alidade
