// SPDX-License-Identifier: MIT
#pragma once

#include "geo/raster_file.h"
#include "visibility/raster/map_picture.h"

// What the commands of visibility have the module do for them (tools/load_module.h).

namespace alidade {

/// write_raster() of geo/raster_file.h. Errors, here and below: those of load_module_function().
using RasterWriter = void (*)(const std::filesystem::path& file, const RasterContents& contents,
                              bool overwrite);
RasterWriter load_raster_writer();

/// write_map_picture() of visibility/raster/map_picture.h.
using MapDrawer = void (*)(const MapPicture& picture, const Ground& ground, const std::filesystem::path& file,
                           bool overwrite);
MapDrawer load_map_drawer();

}  // namespace alidade
