// SPDX-License-Identifier: MIT
#pragma once

#include "visibility/raster_file.h"

// What the commands of visibility have the module do for them (tools/load_module.h).

namespace alidade {

/// write_raster() of visibility/raster_file.h. Errors: those of load_module_function().
using RasterWriter = void (*)(const std::filesystem::path& file, const RasterContents& contents,
                              bool overwrite);
RasterWriter load_raster_writer();

}  // namespace alidade
