// SPDX-License-Identifier: MIT
#include <string>

#include "base/error.h"
#include "base/words.h"
#include "geo/raster_file.h"

// Apart from the writing, so that who only checks the name does not load GDAL.

namespace alidade {

void check_raster_name(const std::filesystem::path& file) {
  const std::string extension = file_ending(file);
  if (extension == ".tif" || extension == ".tiff") return;
  throw Error({.file = file.string(),
               .problem = "maps are written as GeoTIFF",
               .expected = "a name ending in .tif",
               .found = extension.empty() ? "no extension" : extension});
}

}  // namespace alidade
