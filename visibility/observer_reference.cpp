// SPDX-License-Identifier: MIT
#include "visibility/observer_reference.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "octree/error.h"
#include "renderer/gdal_reference.h"
#include "renderer/image_geotiff.h"

namespace alidade {
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

void transform(GivenObserver& observer, const GdalTransformation& transformation) {
  glm::dvec2 place = observer.place;
  if (OCTTransform(transformation.get(), 1, &place.x, &place.y, nullptr) == 0 || !std::isfinite(place.x) ||
      !std::isfinite(place.y)) {
    throw Error({.file = observer.source,
                 .problem = "has no place in the cloud's reference system",
                 .found = fmt::format("{}, {}", observer.place.x, observer.place.y)});
  }
  observer.place = place;
}

}  // namespace

void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const ObserverReference& reference) {
  if (reference.given == "cloud" || observers.empty()) return;
  const QuietGdal quiet;
  const bool is_wkt = reference.given.empty();
  const std::string& option = reference.option;
  const std::string way_out = fmt::format("{0} SYSTEM, or {0} cloud if they are in the cloud's own", option);
  const GdalReference from =
      plane_part(read_reference(is_wkt ? own : reference.given, is_wkt, "the observers", way_out));
  const GdalReference to = plane_part(read_reference(wkt_of(reference.cloud), true, "the cloud", way_out));
  if (!from && !to) return;
  if (!from || !to) {
    throw Error(
        {.file = observers.front().source,
         .problem = to ? "the reference system of the observers is not known, but that of the cloud is"
                       : "the reference system of the cloud is not known, but that of the observers is",
         .expected = to ? way_out : option + " cloud if they are in the cloud's own"});
  }
  if (OSRIsSame(from.get(), to.get()) != 0) return;
  const GdalTransformation transformation = transformation_between(from, to);
  if (!transformation) {
    throw Error({.problem = "there is no way from the observers' reference system to the cloud's",
                 .found = CPLGetLastErrorMsg()});
  }
  for (GivenObserver& observer : observers) transform(observer, transformation);
}

}  // namespace alidade
