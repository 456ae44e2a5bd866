// SPDX-License-Identifier: MIT
#include "geo/gdal_reference.h"

#include <string>

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

}  // namespace alidade
