// SPDX-License-Identifier: MIT
#include "tools/image_module.h"

#include "tools/load_module.h"

namespace alidade {

ImageWriter load_image_writer() {
  return load_module_function<ImageWriter>("alidade_write_image");
}

LegendWriter load_legend_writer() {
  return load_module_function<LegendWriter>("alidade_write_legend");
}

SkyImageReader load_sky_image_reader() {
  return load_module_function<SkyImageReader>("alidade_read_sky_image");
}

SunPlacer load_sun_placer() {
  return load_module_function<SunPlacer>("alidade_place_sun");
}

}  // namespace alidade
