// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/output_file.h"
#include "cloud/crs.h"
#include "image/image_file.h"

namespace alidade {

/// The reference system as WKT: what the file gave, or what its GeoTIFF keys mean, as GDAL reads them. Empty
/// if there is none or nothing can be made of it.
std::string wkt_of(const Crs& crs);

/// Red, green, blue and alpha with 8 bits as in PNG, in tiles, compressed without loss. The film must be that
/// of metadata.camera. The same film gives the same bytes.
void write_geotiff(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                   OutputFile& file);

}  // namespace alidade
