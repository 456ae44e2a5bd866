// SPDX-License-Identifier: MIT
#include "geo/gdal_library.h"

#include <gdal_version.h>

#include "base/shared_library.h"
#include "geo/gdal.h"

namespace alidade::geo {

void* gdal_function(const char* name) {
  // The name of the interface that the headers describe.
  static const SharedLibrary library(ALIDADE_GDAL_LIBRARY,
                                     "maps, reference systems and remote files require GDAL",
                                     "the package " ALIDADE_GDAL_PACKAGE " or an equivalent");
  return library.find(name);
}

void load_gdal() {
  gdal_function("GDALVersionInfo");
}

std::string library_version() {
  return "GDAL " GDAL_RELEASE_NAME;
}

}  // namespace alidade::geo
