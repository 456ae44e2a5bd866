// SPDX-License-Identifier: MIT
#include "tools/map_writer.h"

#include "tools/load_module.h"

namespace alidade {

RasterWriter load_raster_writer() {
  return load_module_function<RasterWriter>("alidade_write_raster");
}

MapDrawer load_map_drawer() {
  return load_module_function<MapDrawer>("alidade_write_map_picture");
}

}  // namespace alidade
