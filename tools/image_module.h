// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "geo/sun.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "renderer/sky.h"

// What the program has the module do for it (load_module.h): writing pictures and legends, reading the
// picture of a sky, and the reference systems (GDAL) that a sun by date and place is turned with.

namespace alidade {

/// write_image() of image/image_file.h.
using ImageWriter = void (*)(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                             bool overwrite);

/// Errors, here and below: those of load_module_function().
ImageWriter load_image_writer();

/// write_legend() of image/legend.h.
using LegendWriter = void (*)(const ColorKey& key, const std::filesystem::path& file,
                              const std::optional<glm::ivec2>& size, bool overwrite);

/// The same for legends.
LegendWriter load_legend_writer();

/// read_sky_image() of image/read_picture.h, into `pixels`.
using SkyImageReader = void (*)(const std::filesystem::path& file, SkyPixels& pixels);
SkyImageReader load_sky_image_reader();

/// place_sun() and describe() of geo/sun.h.
using SunPlacer = void (*)(const SunByTime& by_time, const std::optional<SceneMap>& map, PlacedSun& placed,
                           std::string& description);
SunPlacer load_sun_placer();

}  // namespace alidade
