// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/image.h"
#include "renderer/legend/legend.h"

// Image formats come through OpenImageIO, which brings some 250 libraries: loading them takes longer, and
// more memory, than all the work of most commands. So they stand in a module beside the program, and only who
// writes a picture loads it.

namespace alidade {

/// write_image() of renderer/image.h.
using ImageWriter = void (*)(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                             bool overwrite);

/// Loads the module, which stays loaded. Errors: it is not where the program was built or installed, or it
/// lacks a library.
ImageWriter load_image_writer();

/// write_legend() of renderer/legend/legend.h.
using LegendWriter = void (*)(const ColorKey& key, const std::filesystem::path& file,
                              const std::optional<glm::ivec2>& size, bool overwrite);

/// The same for legends.
LegendWriter load_legend_writer();

}  // namespace alidade
